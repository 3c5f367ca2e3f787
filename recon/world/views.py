"""Views around or past the objects of a world, for rendered recordings."""

from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.files.documents import read_text
from recon.files.rows import rows_of_numbers
from recon.geometry import Array
from recon.records import View

MAX_VIEWS = 10_000
_MAX_BYTES = 1 << 22
_ELEVATION_DEG = 25.0
"""Elevation of a ring's cameras, seen from the centre."""
_ROOM = 1.15
"""Margin around the box in view."""
_PARALLEL = 1e6
"""Distance at which the axes of both cameras meet, relative to the target's: practically
parallel."""


def planned_views(text: str, low: Array, high: Array, fov_deg: float) -> list[View]:
    """Views of the content of a box, as specified by a text.

    Parameters
    ----------
    text : str
        ``ring:N``, a circle around the middle; ``drive:N``, a straight line past it; or a file
        whose rows are the position and the target of a view, six numbers.
    low, high : (3,)
        Corners of the box, world.
    fov_deg : float
        The narrower field of view of the cameras.

    Raises
    ------
    InputError
        For any other text.
    """
    kind, _, number = text.partition(":")
    if kind not in _PLANS:
        return _read(Path(text))
    if not number.isdecimal() or not 0 < int(number) <= MAX_VIEWS:
        raise InputError(f"views are {text!r}, but {kind}:N with N from 1 to {MAX_VIEWS} is needed")
    middle, half = (low + high) / 2, np.linalg.norm(high - low) / 2
    distance = _ROOM * float(half) / np.sin(np.radians(fov_deg) / 2)
    return _PLANS[kind](int(number), middle, distance)


def _ring(count: int, middle: Array, distance: float) -> list[View]:
    elevation = np.radians(_ELEVATION_DEG)
    views = []
    for angle in 2 * np.pi * np.arange(count) / count:
        flat = np.array([np.sin(angle), 0.0, np.cos(angle)])
        side = np.cos(elevation) * flat + np.array([0.0, np.sin(elevation), 0.0])
        views.append(_parallel(middle + distance * side, middle))
    return views


def _drive(count: int, middle: Array, distance: float) -> list[View]:
    steps = np.linspace(-distance / 2, distance / 2, count) if count > 1 else np.zeros(1)
    before = middle + np.array([0.0, 0.0, distance])
    across = np.array([1.0, 0.0, 0.0])
    return [_parallel(before + x * across, middle + x * across) for x in steps]


_PLANS = {"ring": _ring, "drive": _drive}


def _parallel(position: Array, target: Array) -> View:
    """A view whose cameras look straight ahead, side by side."""
    return View(position=position, target=position + _PARALLEL * (target - position))


def _read(path: Path) -> list[View]:
    if not path.is_file():
        raise InputError(f"views are {str(path)!r}, but ring:N, drive:N or a file is needed")
    rows = rows_of_numbers(read_text(path, _MAX_BYTES), 6, path, "x y z of position and target")
    views = [_parallel(row[:3], row[3:]) for row in rows]
    if not 0 < len(views) <= MAX_VIEWS:
        raise InputError(f"{path} has {len(views)} views, but 1 to {MAX_VIEWS} are needed")
    return views
