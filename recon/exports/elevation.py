"""Elevation grids of geographic information systems (ESRI ASCII, .asc)."""

import numpy as np

from recon.errors import InputError
from recon.exports.columns import Columns
from recon.exports.numbers import parsed
from recon.files import check_memory

_KEYS = (b"ncols", b"nrows", b"xllc", b"yllc", b"cellsize", b"nodata_value")
"""Beginnings of the lines of the header."""
_WHOLE = (b"ncols", b"nrows")
_BYTES_PER_CELL = 64.0


def is_grid(content: bytes) -> bool:
    """True for the header of an elevation grid."""
    return content[:5].lower() == b"ncols"


def grid_points(content: bytes) -> Columns:
    """The known cells as points at their centres: x east, y north, z the elevation.

    Raises
    ------
    InputError
        If its header is incomplete, or it has another number of values.
    """
    lines = content.splitlines()
    num = sum(line.lstrip().lower().startswith(_KEYS) for line in lines[: len(_KEYS)])
    header = dict(_entry(line) for line in lines[:num])
    width, height = _need(header, b"ncols"), _need(header, b"nrows")
    check_memory("it", _BYTES_PER_CELL * width * height)
    z = parsed([b" ".join(lines[num:])], None).ravel()
    if len(z) != width * height or not len(z):
        raise InputError(f"{width:g} x {height:g} values are claimed, but {len(z)} follow")
    row, column = np.divmod(np.arange(len(z)), int(width))
    side = _need(header, b"cellsize")
    known = z != header.get(b"nodata_value", np.nan)
    return {
        "x": (_start(header, b"xll", side) + column * side)[known],
        # The first row is the northernmost.
        "y": (_start(header, b"yll", side) + (height - 1 - row) * side)[known],
        "z": z[known],
    }


def _entry(line: bytes) -> tuple[bytes, float]:
    words = line.split()
    if len(words) != 2:
        raise InputError(f"{line[:40]!r} is not a name and a number")
    return words[0].lower(), float(parsed(words[1:], 1)[0, 0])


def _need(header: dict[bytes, float], key: bytes) -> float:
    value = header.get(key, 0.0)
    if not 0 < value < np.inf or (key in _WHOLE and value != np.floor(value)):
        kind = "whole " if key in _WHOLE else ""
        raise InputError(f"its {key.decode()} is {value:g}, but a positive {kind}number is needed")
    return value


def _start(header: dict[bytes, float], axis: bytes, side: float) -> float:
    """The centre of the first cell, from it or from its corner."""
    corner = header.get(axis + b"corner", np.nan)
    start = header.get(axis + b"center", corner + side / 2.0)
    if not np.isfinite(start):
        raise InputError(f"it has no finite {axis.decode()}corner")
    return start
