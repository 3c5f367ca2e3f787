"""Portable float maps, in all common variants."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path

MAX_PIXELS = 1 << 27

# Type, width, height, scale, then one white space (or a two-character newline) before the rows.
_HEADER = re.compile(
    rb"(P[fF])\s(?:\s*#[^\n]*\n)*\s*(\d{1,9})\s+(\d{1,9})\s+([-+]?[\d.]{1,40}(?:[eE][-+]?\d{1,3})?)"
)


def is_pfm(data: bytes) -> bool:
    """True if bytes begin like a portable float map."""
    return data[:2] in (b"Pf", b"PF")


def decode_pfm(data: bytes, name: str) -> NDArray[np.float32]:
    """The numbers (H, W) or (H, W, 3) of a file, top row first, as stored.

    The sign of the scale gives the byte order; its magnitude, an unspecified unit, is ignored.

    Raises
    ------
    InputError
        If the header is invalid, or claims more than the file contains.
    """
    header = _HEADER.match(data)
    if header is None:
        raise InputError(f"{name} has no PFM header (Pf, width, height, scale)")
    kind, width, height = header[1], int(header[2]), int(header[3])
    channels = 3 if kind == b"PF" else 1
    need = 4 * width * height * channels
    if not 0 < width * height <= MAX_PIXELS:
        raise InputError(f"{name} claims {width} x {height} pixels, which are too many")
    start = header.end() + 1
    if data[header.end() : start + 1] == b"\r\n" and len(data) - start > need:
        start += 1
    if len(data) - start < need:
        raise InputError(
            f"{name} claims {width} x {height} pixels, but is cut short after "
            f"{max(0, len(data) - start)} of {need} bytes"
        )
    order = "<" if header[4].startswith(b"-") else ">"
    numbers = np.frombuffer(data, f"{order}f4", width * height * channels, start)
    shape = (height, width, 3) if channels == 3 else (height, width)
    return numbers.reshape(shape)[::-1].astype(np.float32)


def write_pfm(path: Path, values: NDArray[np.floating]) -> None:
    """Write numbers (H, W) as a portable float map, little-endian."""
    height, width = values.shape
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(f"Pf\n{width} {height}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(values[::-1], dtype="<f4").tobytes())
