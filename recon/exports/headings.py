"""Header lines of tables of points: column names that include x, y and z."""

import re

from recon.exports.columns import XYZ

_WORD = re.compile(r"[^\s,;]+")
_UNIT = re.compile(r"\s*[\[(][^\])]*[\])]$")

# Names of x, y and z in surveying, ParaView and other programs.
_PLACES = (
    XYZ,
    ("easting", "northing", "elevation"),
    ("easting", "northing", "height"),
    ("points:0", "points:1", "points:2"),
    ("points_0", "points_1", "points_2"),
    *((f"{mark}x", f"{mark}y", f"{mark}z") for mark in ("pos_", "point_", "coord_", "p")),
    *((f"x{mark}", f"y{mark}", f"z{mark}") for mark in ("_m", "_coord", "coord")),
)  # fmt: skip


def heading(line: bytes) -> tuple[str, ...] | None:
    """The column names in a line; None unless x, y and z, or their synonyms, are among them.

    A column without a name, such as row numbers, is named by its position.
    """
    text = line.decode("utf-8", "replace").lstrip("#/%! ")
    separator = next((mark for mark in ";\t," if mark in text), None)
    words = _WORD.findall(text) if separator is None else text.split(separator)
    names = [word.strip().strip("\"'").strip() for word in words]
    plain = [_UNIT.sub("", name).lower() for name in names]
    called = next((places for places in _PLACES if set(places) <= set(plain)), _fields(plain))
    if called is None:
        return None
    by_place = dict(zip(called, XYZ, strict=True))
    return tuple(
        by_place.get(word, name or f"column_{n}")
        for n, (word, name) in enumerate(zip(plain, names, strict=True))
    )


def _fields(names: list[str]) -> tuple[str, ...] | None:
    """Names such as `field.point.x` of the only vector among the fields of ROS messages."""
    prefixes = [name[:-1] for name in names if name.endswith(".x")]
    places = tuple(f"{prefixes[0]}{axis}" for axis in XYZ) if len(prefixes) == 1 else ()
    return places if places and set(places) <= set(names) else None
