"""Images from files, whole or not at all."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

Image = NDArray[np.uint8]

ENDINGS = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm", ".pgm", ".tga", ".webp"}

_PNG_START = b"\x89PNG\r\n\x1a\n"
_JPEG_START = b"\xff\xd8"
_JPEG_END = b"\xff\xd9"


def read_image(path: Path) -> Image:
    """An image as (H, W) grey or (H, W, 3) RGB uint8; 16 bits are brought to 8.

    Raises
    ------
    InputError
        Where the file is missing, cut short, damaged or no image.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}), but an image is needed"
        ) from error
    return decode(data, str(path))


def decode(data: bytes, name: str) -> Image:
    """The image in the bytes of a file; messages call it `name`."""
    fault = _fault(data)
    if fault:
        raise InputError(f"{name} is {fault}, but a whole image is needed")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_ANYCOLOR)
    if image is None:
        raise InputError(f"{name} is no image that OpenCV can read")
    rgb: Image = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    return rgb


def _fault(data: bytes) -> str | None:
    """What is wrong with a file: OpenCV pads a JPEG that is cut, and libpng writes to stderr."""
    if not data:
        return "empty"
    if data.startswith(_PNG_START):
        return _png_fault(data)
    if data.startswith(_JPEG_START) and not data.rstrip(b"\0").endswith(_JPEG_END):
        return "cut short"
    return None


def _png_fault(data: bytes) -> str | None:
    position = len(_PNG_START)
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        end = position + 12 + length
        if end > len(data):
            break
        (checksum,) = struct.unpack_from(">I", data, end - 4)
        if zlib.crc32(data[position + 4 : end - 4]) != checksum:
            return "damaged (a checksum is wrong)"
        if data[position + 4 : position + 8] == b"IEND":
            return None
        position = end
    return "cut short"
