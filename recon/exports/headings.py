"""Headings of tables of points: the names of columns, x, y and z among them."""

import re

from recon.exports.columns import XYZ

_WORD = re.compile(r"[^\s,;]+")
_UNIT = re.compile(r"\s*[\[(][^\])]*[\])]$")

# What surveyors, ParaView and others call x, y and z.
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
    """The names in a line; None unless x, y and z are among them, whatever they are called.

    A column without a name, as that of a table's row numbers, is called by its number.
    """
    text = line.decode("utf-8", "replace").lstrip("#/%! ")
    separator = next((mark for mark in ";\t," if mark in text), None)
    words = _WORD.findall(text) if separator is None else text.split(separator)
    names = [word.strip().strip("\"'").strip() for word in words]
    plain = [_UNIT.sub("", name).lower() for name in names]
    called = next((places for places in _PLACES if set(places) <= set(plain)), None)
    if called is None:
        return None
    by_place = dict(zip(called, XYZ, strict=True))
    return tuple(
        by_place.get(word, name or f"column_{n}")
        for n, (word, name) in enumerate(zip(plain, names, strict=True))
    )
