"""Noise of one image, estimated from the image itself."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImageNoise:
    """Standard deviations of the noise of a grey image, in grey levels of 255."""

    level: float
    """Of a pixel, over the whole image; at least the rounding noise of integer levels."""
    by_grey: NDArray[np.float32]
    """(256,) of a pixel, per grey level."""
    by_scale: NDArray[np.float32]
    """(S,) of white noise with the filter responses, per scale, of the calmest image regions: above
    `level` if the noise is correlated or no region is calm."""
