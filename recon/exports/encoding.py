"""Images encoded as the bytes of a file, for web pages."""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

ENDINGS = (".png", ".jpg")
JPEG_QUALITY = 88


def encode_image(image: NDArray[np.uint8], ending: str = ".png") -> bytes:
    """The bytes of an image (H, W) or (H, W, 3) RGB as a file with the given suffix.

    Raises
    ------
    InputError
        For a suffix that is not one of ENDINGS.
    """
    if ending not in ENDINGS:
        raise InputError(f"ending is {ending!r}, but one of {', '.join(ENDINGS)} is needed")
    bgr = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if ending == ".jpg" else []
    _, data = cv2.imencode(ending, bgr, quality)
    return bytes(data)
