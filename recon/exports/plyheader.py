"""The header of a PLY file: its elements and the properties of their rows."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from recon.errors import InputError
from recon.exports.names import decoded
from recon.files import PathLike

# Old and new names of the types.
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_NAMES = {code: name for name, code in reversed(_TYPES.items())}
HELD = frozenset(_NAMES)
"""The number types of PLY, as numpy codes."""
_BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "="}

_MAX_HEADER_BYTES = 1_000_000
_END = b"end_header"
_FIRST_LINE = re.compile(rb"(?:\xef\xbb\xbf)?ply[ \t]*(\r\n|\n|\r)")
"""Editors on Windows write a byte-order mark before it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Property:
    """One value of a row, or a list of values with its length."""

    name: str
    dtype: str
    """Type of the value, or of each value of the list."""
    length_dtype: str | None = None
    """Type of the length of a list; None for a single value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """A table of the file."""

    name: str
    count: int
    """Number of rows."""
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        """True if rows may differ in length."""
        return any(one.length_dtype for one in self.properties)

    @property
    def row_dtype(self) -> np.dtype[np.void]:
        """Type of a row without its lists."""
        return np.dtype([(p.name, p.dtype) for p in self.properties if not p.length_dtype])

    @property
    def min_row_bytes(self) -> int:
        """Size of a binary row with empty lists."""
        return sum(np.dtype(p.length_dtype or p.dtype).itemsize for p in self.properties)


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """A file as described by its header."""

    elements: tuple[Element, ...]
    is_text: bool

    def element(self, name: str) -> Element | None:
        """The element of that name; None if there is none."""
        return next((one for one in self.elements if one.name == name), None)


def header(dtype: np.dtype[np.void], count: int, faces: int | None = None) -> bytes:
    """The header of binary vertices, and of triangles after them.

    Its length is independent of the count, so that it can be overwritten.
    """
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count:012d}"]
    for name in dtype.names or ():
        lines.append(f"property {_NAMES[dtype[name].str[1:]]} {name}")
    if faces is not None:
        lines += [f"element face {faces:012d}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""]).encode()


def read_header(file: BinaryIO, path: PathLike) -> Header:
    """Read up to the first row.

    Raises
    ------
    InputError
        If the file is not a PLY file of vertices.
    """
    try:
        found = _parsed(_header_lines(file))
    except (ValueError, KeyError, IndexError, StopIteration) as error:
        raise InputError(f"{path}: not a PLY file of vertices ({error})") from error
    return found


def _header_lines(file: BinaryIO) -> list[list[str]]:
    """The words of each line; the file is then positioned at its first row."""
    content = file.read(_MAX_HEADER_BYTES)
    first = _FIRST_LINE.match(content)
    if first is None:
        raise ValueError("its first line is not ply")
    # Comments may mention the end.
    blank = rb"[ \t\r]*" if first[1] == b"\n" else rb"[ \t]*"
    last = re.search(first[1] + _END + blank + rb"(?:" + first[1] + rb"|\Z)", content)
    if last is None:
        raise ValueError("its header has no end")
    file.seek(last.end())
    return [line.split() for line in re.split(r"[\r\n]+", decoded(content[: last.start()]))]


def _parsed(lines: Sequence[list[str]]) -> Header:
    form = next((words[1] for words in lines if words[:1] == ["format"]), "none")
    starts = [row for row, words in enumerate(lines) if words[:1] == ["element"]]
    ends = [*starts[1:], len(lines)]
    elements = tuple(
        _element(lines[start:end], _BYTE_ORDERS[form])
        for start, end in zip(starts, ends, strict=True)
    )
    if len({one.name for one in elements}) < len(elements):
        raise ValueError("two of its elements have the same name")
    found = Header(elements=elements, is_text=form == "ascii")
    if found.element("vertex") is None:
        raise ValueError("it has no vertices")
    return found


def _element(lines: Sequence[list[str]], order: str) -> Element:
    (_, name, count), *rest = lines
    if int(count) < 0:
        raise ValueError(f"it claims {count} of {name}")
    properties = tuple(_property(words, order) for words in rest if words[:1] == ["property"])
    if not properties and int(count):
        raise ValueError(f"its {name} has no properties")
    names = [one.name for one in properties]
    if len(set(names)) < len(names):
        raise ValueError(f"two properties of its {name} have the same name")
    return Element(name=name, count=int(count), properties=properties)


def _property(words: list[str], order: str) -> Property:
    if words[1] == "list":
        _, _, length, kind, name = words
        return Property(name=name, dtype=order + _TYPES[kind], length_dtype=order + _TYPES[length])
    _, kind, name = words
    return Property(name=name, dtype=order + _TYPES[kind])
