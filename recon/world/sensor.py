"""The faults of a real camera: lens blur, gain, offset and noise."""

import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.settings.world import RenderSettings

GRAIN_REACH = 4.0
"""Radius of the grain's blur kernel, in standard deviations."""


def exposed(
    image: NDArray[np.uint8],
    frame: Array,
    settings: RenderSettings,
    *,
    gain: float = 1.0,
    offset: float = 0.0,
) -> NDArray[np.uint8]:
    """The image (H, W, 3) of a camera: blurred, amplified and noisy as the settings say.

    The noise depends on the seed and the camera's frame only, so that a view is reproducible.
    """
    if settings.blur_px == 0 and settings.noise == 0 and (gain, offset) == (1.0, 0.0):
        return image
    light = image.astype(np.float32)
    if settings.blur_px > 0:
        light = cv2.GaussianBlur(light, (0, 0), settings.blur_px, borderType=cv2.BORDER_REPLICATE)
    rng = np.random.default_rng([settings.noise_seed, zlib.crc32(frame.tobytes())])
    noisy = gain * light + offset + settings.noise * _grain(rng, light, settings.noise_grain_px)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def _grain(rng: np.random.Generator, like: NDArray[np.float32], grain_px: float) -> Array:
    """Noise of standard deviation 1 in every pixel, blurred by `grain_px`."""
    if grain_px == 0:
        return rng.standard_normal(like.shape)
    height, width, num_channels = like.shape
    edge = int(np.ceil(GRAIN_REACH * grain_px))
    white = rng.standard_normal((height + 2 * edge, width + 2 * edge, num_channels))
    kernel = cv2.getGaussianKernel(2 * edge + 1, grain_px)
    blurred = cv2.sepFilter2D(white, cv2.CV_64F, kernel, kernel)
    grain: Array = blurred[edge : edge + height, edge : edge + width] / (kernel**2).sum()
    return grain
