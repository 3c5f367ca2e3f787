"""The header of a LAS or LAZ file (ASPRS 1.0 to 1.4), checked against the file before reading."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from recon.errors import InputError
from recon.exports.lazchunks import Packing, check_chunks, read_packing
from recon.files import check_memory

_MIN_HEADER_BYTES, _MAX_HEADER_BYTES = 227, 375
_RECORD_BYTES, _EXTENDED_BYTES = 54, 60

_LASZIP = b"laszip encoded", 22204
"""User and number of the record that describes the compression."""

# The highest bit of the format marks compressed points.
_COMPRESSED = 0x80
_MIN_POINT_BYTES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)

# LAZ chunks have 50000 points by default; even constant ones take some bytes.
_MAX_POINTS_OF_BYTE = 20_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """A file as described by its header."""

    num_points: int
    point_bytes: int
    start: int
    """Byte offset of the points."""
    is_compressed: bool


def check_header(path: Path) -> Header:
    """The header of a file, checked against the file's size.

    Raises
    ------
    InputError
        If counts, scales, offsets or lengths do not fit the file.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_MAX_HEADER_BYTES)
        try:
            found = _parsed(head)
            _check_scales(head)
            packing = _check_records(file, head, found, size)
        except (struct.error, ValueError, IndexError) as error:
            raise InputError(f"not a whole LAS file ({error})") from error
        _check_points(file, found, size, packing)
    check_memory(path, 3.0 * found.num_points * found.point_bytes)
    return found


def _parsed(head: bytes) -> Header:
    if head[:4] != b"LASF" or len(head) < _MIN_HEADER_BYTES:
        raise ValueError("wrong signature")
    major, minor = head[24:26]
    (start,) = struct.unpack_from("<I", head, 96)
    code, point_bytes, num_points = struct.unpack_from("<BHI", head, 104)
    if (major, minor) >= (1, 4):
        (num_points,) = struct.unpack_from("<Q", head, 247)
    if point_bytes < _MIN_POINT_BYTES[code & 0x3F]:
        raise ValueError(f"points of format {code & 0x3F} have {point_bytes} bytes")
    return Header(
        num_points=num_points, point_bytes=point_bytes, start=start,
        is_compressed=bool(code & _COMPRESSED),
    )  # fmt: skip


def _check_scales(head: bytes) -> None:
    numbers = np.array(struct.unpack_from("<6d", head, 131))
    if not (np.isfinite(numbers).all() and (numbers[:3] != 0).all()):
        raise ValueError(f"its scales are {numbers[:3].tolist()}, offsets {numbers[3:].tolist()}")


def _check_records(file: BinaryIO, head: bytes, found: Header, size: int) -> Packing | None:
    """The packing of the points; variable records precede these, and extended ones follow them."""
    header_bytes, _, count = struct.unpack_from("<HII", head, 94)
    if not header_bytes <= found.start <= size:
        raise ValueError(f"its points begin at byte {found.start} of {size}")
    at, packing = header_bytes, None
    if count * _RECORD_BYTES > found.start - header_bytes:
        raise ValueError(f"{count} variable records are claimed")
    for _ in range(count):
        file.seek(at)
        user, number, length = struct.unpack("<2x16sHH32x", file.read(_RECORD_BYTES))
        if (user.rstrip(b"\0"), number) == _LASZIP:
            packing = read_packing(file.read(length))
        at += _RECORD_BYTES + length
    if at > found.start:
        raise ValueError("its variable records reach into its points")
    if head[25] >= 4:
        first, count = struct.unpack_from("<QI", head, 235)
        if count and (first < found.start or first + count * _EXTENDED_BYTES > size):
            raise ValueError(f"{count} extended records are claimed")
    return packing


def _check_points(file: BinaryIO, found: Header, size: int, packing: Packing | None) -> None:
    held = size - found.start
    claim = f"{found.num_points} points are claimed, but {held} bytes follow"
    if not found.is_compressed:
        if held < found.num_points * found.point_bytes:
            raise InputError(claim)
        return
    if found.num_points > _MAX_POINTS_OF_BYTE * held:
        raise InputError(claim)
    if packing is None:
        raise InputError("not a whole LAZ file (its LASzip record is missing)")
    if found.num_points:
        check_chunks(file, size, (found.start, found.point_bytes, found.num_points), packing)
