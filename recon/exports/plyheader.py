"""The header of a PLY file: what its vertices hold."""

import os
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from recon.errors import InputError

# Both generations of names.
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_NAMES = {code: name for name, code in reversed(_TYPES.items())}
_BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "="}

_MAX_LINES = 1000
_MAX_LINE_BYTES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """What follows a header."""

    dtype: np.dtype[np.void]
    """Of one vertex."""
    count: int
    """Vertices."""
    is_text: bool


def header(dtype: np.dtype[np.void], count: int) -> bytes:
    """The header of binary vertices; as long for every count, so that it can be written again."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count:012d}"]
    for name in dtype.names or ():
        lines.append(f"property {_NAMES[dtype[name].str[1:]]} {name}")
    return "\n".join([*lines, "end_header", ""]).encode("ascii")


def read_header(file: BinaryIO, path: str | os.PathLike[str]) -> Layout:
    """Read up to the first vertex.

    Raises
    ------
    InputError
        Where the file is no PLY of plain vertices, or holds less than it claims.
    """
    try:
        layout = _parsed(_header_lines(file))
    except (ValueError, KeyError, IndexError) as error:
        raise InputError(f"{path}: not a PLY file of plain vertices ({error})") from error
    held = os.fstat(file.fileno()).st_size - file.tell()
    # In a text a vertex takes a digit and a line's end at least.
    if held < layout.count * (2 if layout.is_text else layout.dtype.itemsize):
        raise InputError(f"{path}: {layout.count} vertices are claimed, but {held} bytes follow")
    return layout


def _header_lines(file: BinaryIO) -> list[list[str]]:
    """The words of each line."""
    lines: list[list[str]] = []
    for _ in range(_MAX_LINES):
        words = file.readline(_MAX_LINE_BYTES).decode("ascii").split()
        lines.append(words)
        if lines[0] != ["ply"]:
            raise ValueError("its first line is not ply")
        if words == ["end_header"]:
            return lines
    raise ValueError("its header has no end")


def _parsed(lines: list[list[str]]) -> Layout:
    form, *_ = [words[1] for words in lines if words[:1] == ["format"]]
    first, *others = [row for row, words in enumerate(lines) if words[:1] == ["element"]]
    if lines[first][1] != "vertex":
        raise ValueError(f"its first element is {lines[first][1]}")
    last = others[0] if others else len(lines)
    fields = [
        (words[2], _BYTE_ORDERS[form] + _TYPES[words[1]])
        for words in lines[first:last]
        if words[:1] == ["property"]
    ]
    count = int(lines[first][2])
    if count < 0:
        raise ValueError(f"it claims {count} vertices")
    return Layout(dtype=np.dtype(fields), count=count, is_text=form == "ascii")
