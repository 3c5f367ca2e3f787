"""Sigma of a disparity, from the evidence of its choice.

The laws were fitted on recorded pairs with truth (Venus, Cones, Moebius, Cloth1, Books), so that 68
% of the errors there are below one sigma, and tested on others.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.stereo.dense.choice import Choice
from recon.stereo.kernels.simd import Floats
from recon.stereo.noise import noise_level

FILLED_PX = np.float32(1.0)
"""Sigma of filled pixels: four of five are within a pixel."""
_WINDOW_PX = 7
_NOISE_OF_SLOPE = 3 / 16
"""Variance of the slope of white noise of variance 1."""
_BY_CHANCE = 2.0
"""Energy of a window relative to that of noise, up to which it may be noise alone."""
_TINY = np.float32(1e-6)
_LOWEST_PX, _HIGHEST_PX = 0.03, 8.0


def of_choice(choice: Choice, spread_px: Floats, grey: NDArray[np.uint8]) -> Floats:
    """(H, W) standard deviation of disparities chosen by their cost.

    It decreases with the steepness of the cost and its lead over other disparities, both in grey
    levels, and grows with the distance of the neighbours from a common plane. Where the image is
    flat within its noise, the disparity comes from elsewhere and is uncertain.
    """
    lead = (0.3 + choice.steepness) ** -0.25 * (0.5 + choice.lead) ** -0.59
    return _bounded(np.hypot(23.1 * lead * (0.03 + spread_px) ** 0.52, _least(grey)))


def of_image(spread_px: Floats, grey: NDArray[np.uint8]) -> Floats:
    """(H, W) the same without known costs, from the slope of the image instead.

    A window of N pixels with noise of n grey levels and a slope of s levels per pixel determines
    the disparity no better than ``n / (s sqrt N)``.
    """
    return _bounded(np.hypot(1.3 * (0.03 + spread_px) ** 0.7, _least(grey)))


def _least(grey: NDArray[np.uint8]) -> Floats:
    """(H, W) the lowest sigma that windows of the image allow, given its noise."""
    noise = noise_level(grey)
    slope = cv2.Sobel(grey, cv2.CV_32F, 1, 0, scale=1 / 8, borderType=cv2.BORDER_REPLICATE)
    square = cv2.blur(slope * slope, (_WINDOW_PX, _WINDOW_PX), borderType=cv2.BORDER_REPLICATE)
    texture = square - _BY_CHANCE * _NOISE_OF_SLOPE * noise**2
    least: Floats = noise / (np.sqrt(np.maximum(texture, 0)) * _WINDOW_PX + _TINY)
    return least


def _bounded(sigma_px: Floats) -> Floats:
    return np.clip(sigma_px, _LOWEST_PX, _HIGHEST_PX).astype(np.float32)
