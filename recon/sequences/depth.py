"""Conversion of 16 to 8 bits, with the same stretch for both cameras and all frames."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.notices import notify

Image = NDArray[np.uint8]
Pixels = NDArray[np.uint8] | NDArray[np.uint16]
"""(H, W) grey or (H, W, 3) RGB as it is stored, 8 or 16 bits deep."""

FULL = 65535
LOW_PERCENT, HIGH_PERCENT = 0.1, 99.9
"""Percentiles of the pixels; beyond are hot pixels and highlights."""
MARGIN = 0.05
"""Margin on both sides, as a share of the span, for frames darker or brighter than the first."""
FULL_SHARE = 0.8
"""A larger share of the 16-bit range is treated as the full range."""
NUM_SAMPLES = 100_000
"""Number of pixels sampled per image."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Levels mapped to black and white."""

    low: float = 0.0
    high: float = FULL

    def __call__(self, pixels: Pixels) -> Image:
        """The image in 8 bits; an 8-bit image is unchanged."""
        if pixels.dtype == np.uint8:
            return pixels.astype(np.uint8, copy=False)
        scaled = (pixels.astype(np.float32) - self.low) * (255.0 / (self.high - self.low))
        eight: Image = np.clip(np.rint(scaled), 0, 255).astype(np.uint8)
        return eight


def stretch_of(images: Sequence[Pixels]) -> Stretch:
    """The stretch that covers the levels of both cameras' images; reported for 16 bits.

    Pixels of 0 are ignored unless there are no others: they are masked, not dark.
    """
    deep = [_sample(pixels) for pixels in images if pixels.dtype == np.uint16]
    if not deep:
        return Stretch()
    levels = np.concatenate(deep)
    seen = levels[levels > 0] if levels.any() else levels
    low, high = np.percentile(seen, [LOW_PERCENT, HIGH_PERCENT])
    margin = max(MARGIN * (high - low), 1.0)
    low, high = max(0.0, low - margin), min(float(FULL), high + margin)
    if high - low >= FULL_SHARE * FULL:
        low, high = 0.0, float(FULL)
    notify(
        "depth-stretched",
        f"images have 16 bits: levels {low:.0f} to {high:.0f} become 0 to 255, in both cameras and "
        "all frames",
    )
    return Stretch(float(low), float(high))


def _sample(pixels: Pixels) -> NDArray[np.uint16]:
    flat = pixels.ravel()
    return flat[:: max(1, flat.size // NUM_SAMPLES)].astype(np.uint16)
