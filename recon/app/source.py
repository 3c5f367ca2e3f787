"""Images as data URLs."""

import base64

import numpy as np
from numpy.typing import NDArray

from recon.exports.encoding import encode_image


def as_source(image: NDArray[np.uint8], ending: str = ".png") -> str:
    """An image as a data URL."""
    data = base64.b64encode(encode_image(image, ending)).decode()
    return f"data:image/{ending.removeprefix('.').replace('jpg', 'jpeg')};base64,{data}"
