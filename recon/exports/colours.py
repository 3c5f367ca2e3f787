"""Colours of points as named and scaled by other programs, converted to 8 bits."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.notices import notify

_TRIPLES = (
    ("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("rf", "gf", "bf"), ("red_", "green_", "blue_"),
)  # fmt: skip
_PACKED = ("rgb", "rgba", "colour", "color")

# From 16 bits to 8: 65535 becomes 255.
_WIDE_FACTOR = 257.0
_ROUNDING = 1e-4


def colour_names(columns: Mapping[str, NDArray[Any]]) -> tuple[str, ...]:
    """Names of the three colour columns, or of the packed one; empty if there are none.

    Case does not matter.
    """
    by_lower = {name.lower(): name for name in reversed(list(columns))}
    for names in _TRIPLES:
        if set(names) <= by_lower.keys():
            return tuple(by_lower[name] for name in names)
    for name in _PACKED:
        if name in by_lower and columns[by_lower[name]].dtype.itemsize == 4:
            return (by_lower[name],)
    return ()


def colours_of(columns: Mapping[str, NDArray[Any]], names: tuple[str, ...]) -> NDArray[np.uint8]:
    """The colours (N, 3) in the columns `names`.

    Raises
    ------
    InputError
        For levels < 0 or > 16 bits.
    """
    if len(names) == 1:
        return unpacked(columns[names[0]])
    return as_bytes(np.column_stack([columns[name] for name in names]))


def unpacked(values: NDArray[Any]) -> NDArray[np.uint8]:
    """Colours (N, 3) from 0xRRGGBB; floats are reinterpreted as bits, as in PCL."""
    bits = np.ascontiguousarray(values).view(np.uint32)
    return np.column_stack([(bits >> shift) & 255 for shift in (16, 8, 0)]).astype(np.uint8)


def as_bytes(levels: NDArray[Any]) -> NDArray[np.uint8]:
    """Levels (N, 3) of 8 or 16 bits, or shares from 0 to 1, as 8 bits.

    Floats all between 0 and 1 are shares; integers above 255 have 16 bits.
    """
    if levels.dtype == np.uint8:
        return levels
    values = levels.astype(np.float64)
    unknown = ~np.isfinite(values).all(axis=1)
    if unknown.any():
        notify("colour-missing", f"{unknown.sum()} points have no colour; they are black")
        values[unknown] = 0.0
    low, high = values.min(initial=0.0), values.max(initial=0.0)
    if low < -_ROUNDING or high > 65535.0 + _ROUNDING:
        raise InputError(f"colours go from {low:g} to {high:g}, but 0 to 255 or 65535 are needed")
    if levels.dtype.kind in "fb" and high <= 1.0 + _ROUNDING:
        values *= 255.0
    elif high > 255.0 + _ROUNDING:
        values /= _WIDE_FACTOR
    rounded: NDArray[np.uint8] = np.rint(values.clip(0.0, 255.0)).astype(np.uint8)
    return rounded
