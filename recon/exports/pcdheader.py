"""The header of a PCD file, checked before its points are read."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from recon.errors import InputError
from recon.exports.names import decoded

_TYPES = {"F": "f", "U": "u", "I": "i"}
_SIZES = {"f": (4, 8), "u": (1, 2, 4, 8), "i": (1, 2, 4, 8)}
HELD = frozenset(f"{kind}{size}" for kind, sizes in _SIZES.items() for size in sizes)
"""The number types of PCD, as numpy codes."""

_MAX_HEADER_BYTES = 100_000
_MAX_VALUES = 100_000
_KEYS = (
    "VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT",
    "POINTS", "DATA",
)  # fmt: skip
_LAYOUTS = ("ascii", "binary", "binary_compressed")


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """The points of a file as described by its header."""

    names: tuple[str, ...]
    dtypes: tuple[str, ...]
    counts: tuple[int, ...]
    """Number of values of each field per point."""
    width: int
    height: int
    layout: str
    """One of ascii, binary, binary_compressed."""

    @property
    def num_points(self) -> int:
        """Number of points, measured or not."""
        return self.width * self.height

    @property
    def num_values(self) -> int:
        """Number of values per point, including padding."""
        return sum(self.counts)

    @property
    def point_bytes(self) -> int:
        """Bytes per binary point."""
        sizes = [np.dtype(code).itemsize for code in self.dtypes]
        return sum(size * count for size, count in zip(sizes, self.counts, strict=True))


def parse_header(content: bytes) -> tuple[Header, int]:
    """The header, and where the points start.

    Raises
    ------
    InputError
        If a line is missing, or lines contradict each other.
    """
    lines: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in lines:
        end = content.find(b"\n", at, _MAX_HEADER_BYTES)
        if end < 0:
            raise InputError("not a PCD file (its header has no end)")
        words = decoded(content[at:end]).split("#")[0].split()
        at = end + 1
        if words:
            if words[0].upper() not in _KEYS:
                raise InputError(f"not a PCD file ({words[0][:20]!r} is not a line of its header)")
            lines[words[0].upper()] = words[1:]
    try:
        return _header(lines), at
    except (KeyError, ValueError, IndexError, OverflowError) as error:
        raise InputError(f"not a PCD file ({error})") from error


def _header(lines: Mapping[str, list[str]]) -> Header:
    names = lines.get("FIELDS") or lines["COLUMNS"]
    counts = [int(word) for word in lines.get("COUNT", ["1"] * len(names))]
    kinds = lines.get("TYPE", ["F"] * len(names))
    sizes = lines.get("SIZE", ["4"] * len(names))
    dtypes = [
        f"<{_TYPES[kind.upper()]}{int(size)}" for kind, size in zip(kinds, sizes, strict=True)
    ]
    if not len(names) == len(dtypes) == len(counts):
        raise ValueError("its fields, sizes, types and counts differ in number")
    if min(counts) < 1 or sum(counts) > _MAX_VALUES:
        raise ValueError(f"a count is {min(counts)}, or all are {sum(counts)}")
    if not {code[1:] for code in dtypes} <= HELD:
        raise ValueError(f"a type is none of {' '.join(sorted(HELD))}")
    width, height = _shape(lines)
    layout = lines["DATA"][0].lower()
    if layout not in _LAYOUTS:
        raise ValueError(f"its data are {layout!r}")
    return Header(
        names=tuple(names), dtypes=tuple(dtypes), counts=tuple(counts), width=width,
        height=height, layout=layout,
    )  # fmt: skip


def _shape(lines: Mapping[str, list[str]]) -> tuple[int, int]:
    """Width and height, which have to agree with the number of points."""
    points = int(lines["POINTS"][0]) if "POINTS" in lines else None
    width = int(lines["WIDTH"][0]) if "WIDTH" in lines else points
    height = int(lines.get("HEIGHT", ["1"])[0])
    if width is None or min(width, height) < 0:
        raise ValueError(f"it is {width} x {height} points")
    if points is not None and points != math.prod((width, height)):
        raise ValueError(f"it claims {points} points, and {width} x {height}")
    return width, height
