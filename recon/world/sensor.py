"""What a real camera does to an image: lens blur and noise."""

import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.settings.world import RenderSettings


def exposed(
    image: NDArray[np.uint8], T_world_eye: Array, settings: RenderSettings
) -> NDArray[np.uint8]:
    """The image (H, W, 3) of an eye, blurred and noisy as the settings say.

    The noise comes from the seed and the pose, so that a view looks the same whenever it is taken.
    """
    if settings.blur_px == 0 and settings.noise == 0:
        return image
    light = image.astype(np.float32)
    if settings.blur_px > 0:
        light = cv2.GaussianBlur(light, (0, 0), settings.blur_px, borderType=cv2.BORDER_REPLICATE)
    rng = np.random.default_rng([settings.noise_seed, zlib.crc32(T_world_eye.tobytes())])
    noisy = light + settings.noise * rng.standard_normal(light.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
