"""Noise of one image, as estimated from the image itself."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImageNoise:
    """Standard deviations of the noise of a grey image, in grey levels of 255."""

    level: float
    """Of a pixel, over the whole image; never below the noise of rounding to whole levels."""
    by_grey: NDArray[np.float32]
    """(256,) of a pixel, by its grey level."""
    by_scale: NDArray[np.float32]
    """(S,) of white noise that would answer the filters of a scale as the calmest parts of the
    image do: above `level` where noise is correlated, or where no part of the image is calm."""
