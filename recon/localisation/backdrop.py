"""Backdrop: the colours behind everything, in bands of elevation."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.drawing import Camera, Drawn
from recon.localisation.likelihood import LEVELS, LOG_ANY, NUM_BANDS, bands

SEEN_SHARE = 0.95
"""Share of the pixels behind everything that have colours seen there before."""
APART_PX = 2
"""Distance from what is drawn at which nothing of it is seen."""
LEAST_SIGMA = 6.0
"""Standard deviation of a channel of a plain backdrop."""


@dataclass(slots=True, eq=False)
class Backdrop:
    """Numbers and sums of colours."""

    counts: Array = field(default_factory=lambda: np.zeros((NUM_BANDS, LEVELS, LEVELS, LEVELS)))
    sums: Array = field(default_factory=lambda: np.zeros((NUM_BANDS, 2, 3)))
    """Of colours and of their squares."""

    def add(self, image: NDArray[np.uint8], drawn: Drawn, camera: Camera) -> None:
        """Count the colours of an image where nothing is drawn, by their elevation."""
        side = 2 * APART_PX + 1
        is_drawn = cv2.dilate((drawn.solid >= 0).astype(np.uint8), np.ones((side, side), np.uint8))
        row, column = np.nonzero(is_drawn == 0)
        x, y = (column - camera.cx_px) / camera.focal_px, (row - camera.cy_px) / camera.focal_px
        rise = bands(camera.turn[1, 0] * x + camera.turn[1, 1] * y + camera.turn[1, 2], x, y)
        colour = image[row, column]
        red, green, blue = (colour >> 4).astype(np.intp).T
        np.add.at(self.counts, (rise, red, green, blue), 1.0)
        for power in (1, 2):
            for channel in range(3):
                values = colour[:, channel].astype(np.float64) ** power
                self.sums[:, power - 1, channel] += np.bincount(rise, values, NUM_BANDS)

    @property
    def log_density(self) -> Array:
        """Log density of the colours of each band; any colour may occur."""
        total = np.maximum(self.counts.sum(axis=(1, 2, 3), keepdims=True), 1.0)
        seen = SEEN_SHARE * self.counts / total * (LEVELS / 256.0) ** 3
        density: Array = np.log(seen + (1.0 - SEEN_SHARE) * math.exp(LOG_ANY))
        return density

    @property
    def mean(self) -> Array:
        """(B, 3) mean colour of each band; grey where none was seen."""
        number = self.counts.sum(axis=(1, 2, 3))[:, None]
        return np.where(number > 0.0, self.sums[:, 0] / np.maximum(number, 1.0), 128.0)

    @property
    def sigma(self) -> Array:
        """(B,) standard deviation of a channel in each band; any where none was seen."""
        number = self.counts.sum(axis=(1, 2, 3))
        mean_sq = self.sums[:, 1] / np.maximum(number, 1.0)[:, None]
        variance = np.maximum(mean_sq - self.mean**2, 0.0).mean(axis=1)
        return np.where(number > 0.0, np.hypot(np.sqrt(variance), LEAST_SIGMA), 80.0)
