"""Gaps between the views of an obstacle, and the value of a view that closes a part of them."""

import math

import numpy as np
from numba import njit

from recon.exploration.floor import Array, Mask

ROOM, RISK = 0.3, 0.5
"""Share of a side, and the number of further views expected at most if the views of a gap overlap
by less than it: not all positions are reachable."""
LEAST = 0.3
"""Share of its value that is left of a view after which as many are needed as before."""
LAST = 0.5
"""A view that closes all gaps of an obstacle is worth at least this share of a whole side, since it
makes the obstacle known."""


@njit(cache=True)
def values_of(missing: Mask, side: float) -> Array:
    """Share (2, B) of a side that a view would add, by the bearing at which it begins.

    Views that save a later one are worth most: one from behind, after which both gaps beside it
    need a view each, is worth less than one after which a single gap is left.

    Parameters
    ----------
    missing : (B,) bool
        Bearings, all around, that no view covers.
    side : float
        Number of bearings that one view covers; it is rounded down for the first row of the result,
        and up for the second one.
    """
    number = len(missing)
    values, needed = np.zeros((2, number)), _needed(missing, np.argmin(missing), 0, side)
    for more in range(2):
        for first in range(number if needed > 0.0 else 0):
            share = _count(missing, first, int(side) + more) / side
            later = _needed(missing, first, int(side) + more, side)
            if share > 0.0 and later == 0.0:
                share = max(share, LAST)
            values[more, first] = share * max(LEAST, min(needed - later, 1.0))
    return values


@njit(cache=True)
def _count(missing: Mask, first: int, width: int) -> int:
    """Number of missing bearings among some neighbouring ones."""
    number = 0
    for bearing in range(first, first + width):
        number += missing[bearing % len(missing)]
    return number


@njit(cache=True)
def _needed(missing: Mask, first: int, width: int, side: float) -> float:
    """Expected number of views of the missing bearings, without a width of them from a first one.

    If the width is zero, the first one is not missing, unless all are.
    """
    needed, gap = 0.0, 0
    for bearing in range(first + width, first + len(missing)):
        if missing[bearing % len(missing)]:
            gap += 1
        elif gap:
            needed, gap = needed + _views(gap / side), 0
    rest: float = _views(gap / side)
    return needed + rest


@njit(cache=True)
def _views(sides: float) -> float:
    """Expected number of views of a gap with a width of some sides."""
    number = math.ceil(sides)
    return number + RISK * max(0.0, 1.0 - (number - sides) / ROOM) if sides > 0.0 else 0.0
