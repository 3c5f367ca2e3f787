"""Arrays by name, (N,) or (N, K), as single columns: clouds in files of numpy and Zarr."""

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import NORMAL, RGB, XYZ, Columns
from recon.exports.text import names_by_kind

log = logging.getLogger(__name__)

# Names of the arrays of points, ours and those of other programs.
_POINTS = ("points", "xyz", "pos", "positions", "vertices", "pc", "point_cloud", "pointcloud")
_COLOURS = ("colours", "colors", "rgb", "colour", "color")
_NORMALS = ("normals", "normal")
_MOST_COLUMNS = 16
"""More columns than this mean an image, or with only 3 or 4 rows a transposed array, unless it is
named."""


def columns_in(arrays: Mapping[str, NDArray[Any]]) -> Columns:
    """Split arrays of rows into single columns."""
    points = _points(arrays)
    named = {points: XYZ} if points else {}
    num = (
        len(np.atleast_1d(arrays[points]))
        if points
        else max(map(np.size, arrays.values()), default=0)
    )
    columns: Columns = {}
    dropped = []
    for name, values in arrays.items():
        is_colour = name.lower() in _COLOURS
        names = named.get(name) or (RGB if is_colour else NORMAL)
        if (is_colour or name.lower() in _NORMALS) and np.shape(values)[:1] != (num,):
            raise InputError(
                f"{name} has shape {values.shape}, but one row for each of {num} points is needed"
            )
        if values.dtype.kind not in "biuf" or values.ndim not in (1, 2) or len(values) != num:
            if name == points:
                raise InputError(f"{name} is {values.dtype} {values.shape}, not numbers (N, 3)")
            dropped.append(name)
        elif values.ndim == 1:
            columns[name] = values
        elif name in named or is_colour or name.lower() in _NORMALS:
            columns |= _split(name, values, names)
        else:
            columns |= {f"{name}_{n}": column for n, column in enumerate(values.T)}
    if dropped:
        log.info("arrays without one value per point are left out: %s", dropped)
    return columns


def _points(arrays: Mapping[str, NDArray[Any]]) -> str | None:
    """The name of the array of points; None if x, y and z are separate arrays."""
    lower = {name.lower(): name for name in arrays}
    found = next((lower[name] for name in _POINTS if name in lower), None)
    if found is None and not set(XYZ) <= lower.keys():
        alike = [n for n, v in arrays.items() if v.ndim == 2 and _may_be_points(v.shape)]
        if len(alike) != 1:
            held = ", ".join(f"{name} {values.shape}" for name, values in arrays.items())
            raise InputError(f"its arrays are {held[:200]}, but points (N, 3) is needed")
        return alike[0]
    return found


def _may_be_points(shape: tuple[int, ...]) -> bool:
    """True for rows of a few numbers, also transposed, which is refused later."""
    return 3 <= shape[1] <= _MOST_COLUMNS or (shape[1] > _MOST_COLUMNS and shape[0] in (3, 4))


def _split(name: str, values: NDArray[Any], names: tuple[str, ...]) -> Columns:
    """The columns of an array; columns after the first three are identified by their range."""
    if names == XYZ and len(values) in (3, 4) and values.shape[1] > _MOST_COLUMNS:
        raise InputError(
            f"{name} has shape {values.shape}, but one row per point is needed: transpose it"
        )
    if values.shape[1] < len(names):
        raise InputError(f"{name} has shape {values.shape}, but (N, 3) is needed")
    if names == XYZ and values.shape[1] > len(XYZ):
        names = names_by_kind(values.astype(np.float64))
    return dict(zip(names, values.T, strict=False))
