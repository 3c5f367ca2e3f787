"""The chunks of compressed points (LASzip), checked before the reader allocates what they claim."""

import struct
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from recon.errors import InputError

_NO_TABLE = -1
_LAYERED = 3
_VARIABLE = 2**32 - 1
_MAX_CHUNK = 1_000_000
"""Points of a chunk (50,000 by default) for which the reader may allocate memory whatever the file
contains."""
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}
"""Number of layers of each kind of item: points, RGB, RGB with infrared, waveforms. Any other kind
has one per byte."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Packing:
    """The items of a compressed point, as the LASzip record describes them."""

    items: tuple[tuple[int, int], ...]
    """Kind and number of bytes of each."""
    is_layered: bool
    """True if every chunk has a layer, with its length, for each attribute."""
    chunk_size: int
    """Number of points of a chunk; `_VARIABLE` if each has its own."""

    @property
    def num_layers(self) -> int:
        """Layers of a chunk."""
        return sum(_LAYERS.get(kind, num_bytes) for kind, num_bytes in self.items)


def read_packing(record: bytes) -> Packing:
    """The content of the LASzip record."""
    compressor, chunk_size = struct.unpack_from("<H10xI", record)
    (count,) = struct.unpack_from("<H", record, 32)
    items = tuple(struct.unpack_from("<HH", record, 34 + 6 * number) for number in range(count))
    return Packing(items=items, is_layered=compressor == _LAYERED, chunk_size=chunk_size)


def check_chunks(file: BinaryIO, size: int, points: tuple[int, int, int], packing: Packing) -> None:
    """Check the table of chunks of a file of some size, and the layers of the chunks before it.

    Parameters
    ----------
    points : (int, int, int)
        Byte offset of the points, bytes of one, and their number.

    Raises
    ------
    InputError
        If they do not fit the file.
    """
    start, point_bytes, num_points = points
    if max(num_points, _MAX_CHUNK) < packing.chunk_size < _VARIABLE:
        raise InputError(
            f"not a whole LAZ file (chunks of {packing.chunk_size} points are claimed)"
        )
    if sum(num_bytes for _, num_bytes in packing.items) != point_bytes:
        raise InputError(f"not a whole LAZ file (its items are not points of {point_bytes} bytes)")
    place = _place_of_table(file, start, size)
    if not start + 8 <= place <= size - 8:
        raise InputError("not a whole LAZ file (its table of chunks is missing)")
    file.seek(place)
    version, count = struct.unpack("<II", file.read(8))
    if version or count > min(num_points, size):
        raise InputError(f"not a whole LAZ file ({count} chunks are claimed)")
    if packing.is_layered:
        _check_layers(file, (start + 8, place), count, (point_bytes, packing.num_layers))


def _place_of_table(file: BinaryIO, start: int, size: int) -> int:
    file.seek(start)
    place = _int64(file.read(8))
    if place != _NO_TABLE:
        return place
    file.seek(size - 8)
    return _int64(file.read(8))


def _check_layers(
    file: BinaryIO, ends: tuple[int, int], num_chunks: int, lengths: tuple[int, int]
) -> None:
    """Check that all chunks, each of a point, a count and layers, lie between both ends."""
    point_bytes, num_layers = lengths
    at, end = ends
    for number in range(num_chunks):
        file.seek(at + point_bytes)
        layers = np.frombuffer(file.read(4 + 4 * num_layers), "<u4")[1:]
        at = file.tell() + int(layers.sum(dtype=np.int64))
        if at > end:
            raise InputError(f"not a whole LAZ file (chunk {number} reaches beyond its points)")


def _int64(content: bytes) -> int:
    return int.from_bytes(content, "little", signed=True)
