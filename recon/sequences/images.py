"""Images from files, complete or not at all."""

import io
import struct
import warnings
import zlib
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.libraries import silent
from recon.notices import notify
from recon.sequences.depth import FULL, Image, Pixels, stretch_of
from recon.sequences.jpeg import has_all_parts, may_be_cut, probed
from recon.sequences.recent import recent_image
from recon.sequences.text import read_bytes

ENDINGS = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm", ".pgm", ".tga", ".webp"}
MAX_BYTES = 1 << 30
MAX_PIXELS = 1 << 27
"""Maximum number of pixels in a header: 130 megapixels."""

_FORMATS = ("PNG", "JPEG", "BMP", "TIFF", "PPM", "TGA", "WEBP")
"""Pillow formats of camera images; others may run programs."""
_PNG_START = b"\x89PNG\r\n\x1a\n"
_PNG_DEPTH = 24
"""Byte of a PNG with the bit depth."""
_JPEG_START = b"\xff\xd8"
_TIFF_STARTS = (b"II*\0", b"MM\0*")
_EXIF_ORIENTATION = 274
_EXIF_UPRIGHT = (0, 1)
_FAULTS = (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError,
           OverflowError, MemoryError, struct.error, zlib.error)  # fmt: skip
"""Errors of Pillow for damaged files."""

cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


def read_image(path: Path, eight_bits: Callable[[Pixels], Image] | None = None) -> Image:
    """An image as (H, W) grey or (H, W, 3) RGB uint8.

    Parameters
    ----------
    path : Path
    eight_bits : callable, optional
        Conversion from 16 to 8 bits; by default a stretch of this image.

    Raises
    ------
    InputError
        If the file is missing, truncated, damaged or not an image.
    """
    return (eight_bits or _own_stretch)(read_pixels(path))


def read_pixels(path: Path) -> Pixels:
    """An image as stored, grey or RGB, 8 or 16 bits; see `read_image`."""
    return recent_image(path, lambda: decode_pixels(read_bytes(path, MAX_BYTES), str(path)))


def decode(data: bytes, name: str) -> Image:
    """The image in the bytes of a file, called `name` in messages."""
    return _own_stretch(decode_pixels(data, name))


def decode_pixels(data: bytes, name: str) -> Pixels:
    """The image in the bytes of a file, as stored.

    Transparent pixels become black. The EXIF orientation is ignored: the camera was calibrated with
    the images as stored.
    """
    if not data:
        raise InputError(f"{name} is empty, but a whole image is needed")
    if data.startswith(_PNG_START) and (fault := _png_fault(data)):
        raise InputError(f"{name} is {fault}, but a whole image is needed")
    if data.startswith(_PNG_START) and data[_PNG_DEPTH] == 16:
        return masked(_opencv(data, name))
    return _pillow(data, name)


def masked(pixels: Pixels) -> Pixels:
    """Pixels (H, W) or (H, W, 1 to 4) without alpha, black where it is below one half."""
    if pixels.ndim == 2:
        return pixels
    channels = pixels.shape[2]
    colour = pixels[..., : 3 if channels > 2 else 1]
    if channels in (2, 4):
        opaque = pixels[..., -1:] > np.iinfo(pixels.dtype).max // 2
        colour = colour * opaque.astype(pixels.dtype)
    plain: Any = np.ascontiguousarray(colour if channels > 2 else colour[..., 0])
    return cast("Pixels", plain)


def _own_stretch(pixels: Pixels) -> Image:
    return stretch_of([pixels])(pixels)


def _opencv(data: bytes, name: str) -> Pixels:
    """An image decoded by OpenCV."""
    try:
        stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise InputError(f"{name} has a size that cannot be read") from error
    if stored is None or stored.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{name} is not an image that can be read")
    order = {3: cv2.COLOR_BGR2RGB, 4: cv2.COLOR_BGRA2RGBA}
    channels = 1 if stored.ndim == 2 else stored.shape[2]
    rgb: Pixels = cv2.cvtColor(stored, order[channels]) if channels in order else stored
    return rgb


def _pillow(data: bytes, name: str) -> Pixels:
    image = _loaded(data, name)
    orientation = image.getexif().get(_EXIF_ORIENTATION, 1)
    if orientation not in _EXIF_UPRIGHT and not data.startswith(_TIFF_STARTS):
        notify(
            "exif-ignored",
            f"images are marked as rotated (EXIF orientation {orientation}), which is "
            "ignored: they are used as the camera stored them",
        )
    pixels = _array(image, data, name)
    if data.startswith(_JPEG_START) and _is_cut(data, pixels, name):
        raise InputError(f"{name} is cut short, but a whole image is needed")
    return pixels


def _is_cut(data: bytes, pixels: Pixels, name: str) -> bool:
    """True if a decoded JPEG lacks a part."""
    if not has_all_parts(data):
        return True
    if not may_be_cut(data, pixels):
        return False
    return not np.array_equal(pixels, _array(_loaded(probed(data), name), data, name))


def _loaded(data: bytes, name: str) -> Any:
    """Pillow's image, decoded."""
    import PIL.Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            image = PIL.Image.open(io.BytesIO(data), formats=_FORMATS)
            _check_claim(image.size, name)
            # libtiff prints messages about damaged files.
            with silent() if data.startswith(_TIFF_STARTS) else nullcontext():
                image.load()
        except PIL.UnidentifiedImageError as error:
            raise InputError(f"{name} is not an image that can be read") from error
        except PIL.Image.DecompressionBombError as error:
            raise InputError(f"{name} claims more pixels than allowed") from error
        except InputError:
            raise
        except _FAULTS as error:
            fault = f"{name} is {_reason(error)}"
            raise InputError(f"{fault}, but a whole image is needed") from error
    return image


def _check_claim(size: tuple[int, int], name: str) -> None:
    if size[0] * size[1] > MAX_PIXELS:
        raise InputError(f"{name} claims {size[0]} x {size[1]} pixels, which are too many")


def _reason(error: BaseException) -> str:
    """A short description of the damage, from the various messages of libraries."""
    text = str(error).lower()
    cut = any(word in text for word in ("truncated", "cut", "not processed", "end of", "eof"))
    return "cut short" if cut or isinstance(error, EOFError) else "damaged"


def _array(image: Any, data: bytes, name: str) -> Pixels:
    """Pillow's image as an array, by its mode."""
    if image.mode in ("I;16", "I;16B", "I;16L", "I;16N"):
        grey: Pixels = np.asarray(image).astype(np.uint16)
        return grey
    if image.mode == "I":
        return _sixteen_bits(np.asarray(image), name)
    if image.mode == "F":
        raise InputError(f"{name} contains floating-point numbers, but 8 or 16 bits are needed")
    if data.startswith(_TIFF_STARTS) and image.mode not in ("1", "L", "LA", "P", "RGB", "RGBA"):
        return masked(_opencv(data, name))
    has_alpha = "transparency" in image.info or image.mode in ("PA", "La", "RGBa")
    wanted = {"1": "L", "L": "L", "LA": "LA", "RGB": "RGB", "RGBA": "RGBA"}.get(image.mode)
    mode = "RGBA" if has_alpha and image.mode in ("P", "PA") else (wanted or "RGB")
    return masked(np.asarray(image.convert(mode)))


def _sixteen_bits(levels: NDArray[np.int32], name: str) -> Pixels:
    """Levels (H, W) stored in 32 bits."""
    low, high = levels.min(), levels.max()
    if low < 0 or high > FULL:
        raise InputError(f"{name} has levels {low} to {high}, but 0 to {FULL} are needed")
    return levels.astype(np.uint16)


def _png_fault(data: bytes) -> str | None:
    """The fault of a PNG, which libpng would write to stderr."""
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
