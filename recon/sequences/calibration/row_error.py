"""Residual of a rectification: a smooth offset of rows and disparities in the right image.

Real rigs are never perfectly rectified. A disparity offset of a pixel can put everything ten
percent too far away, with a path too long by as much; it is observable, since the wrong disparities
of a point do not fit a common motion.
"""

import dataclasses
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.sequences.odometry.tracking import Sightings, Tracks

Array = NDArray[np.float64]
NUM_TERMS = 6
Maps = tuple[NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Field:
    """An offset in pixels as a polynomial of the position in the right image."""

    coefficients: Array = dataclasses.field(default_factory=lambda: np.zeros(NUM_TERMS))
    """(6,) of 1, x, y, x^2, xy, y^2, with x, y = -1 to 1 across the image."""

    def at(self, points_px: Array, rig: StereoRig) -> Array:
        """(N,) offsets at points (N, 2)."""
        offsets: Array = terms(points_px, rig) @ self.coefficients
        return offsets


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Residual:
    """Offsets to add to disparities, and of rows downwards in the right image."""

    disparity: Field = Field()
    row: Field = Field()

    def corrected(self, tracks: Tracks, rig: StereoRig) -> Tracks:
        """The tracks as seen by a perfect rig."""
        return Tracks(
            first=self._corrected(tracks.first, rig), second=self._corrected(tracks.second, rig)
        )

    def _corrected(self, seen: Sightings, rig: StereoRig) -> Sightings:
        right = seen.right_points_px
        return Sightings(
            points_px=seen.points_px,
            disparity_px=seen.disparity_px + self.disparity.at(right, rig),
            row_offset_px=seen.row_offset_px - self.row.at(right, rig),
        )

    def maps(self, rig: StereoRig) -> Maps | None:
        """(u, v) of the source of each pixel of the corrected right image."""
        if not self.disparity.coefficients.any() and not self.row.coefficients.any():
            return None
        return _maps(self, rig)


@lru_cache(maxsize=1)
def _maps(residual: Residual, rig: StereoRig) -> Maps:
    """The maps of a recording, kept: it is read several times, and they take longer than a pair."""
    v, u = np.mgrid[: rig.height, : rig.width].astype(np.float64)
    points = np.column_stack([u.ravel(), v.ravel()])
    source_u, source_v = (
        (grid + field.at(points, rig).reshape(grid.shape)).astype(np.float32)
        for grid, field in ((u, residual.disparity), (v, residual.row))
    )
    return source_u, source_v


def terms(points_px: Array, rig: StereoRig) -> Array:
    """(N, 6) polynomial terms at points (N, 2)."""
    x, y = ((points_px / ((rig.width - 1) / 2, (rig.height - 1) / 2)) - 1.0).T
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
