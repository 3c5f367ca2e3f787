"""Summit: where a value of several amounts is highest."""

import math
from collections.abc import Callable

import numpy as np

from recon.geometry import Array

MOST_STEPS = 1.5
"""Maximum number of steps at a time."""


def summit(value: Callable[[Array], float], number: int, steps: Array) -> Array:
    """Amounts (K,), from 0 on, at which a value is highest, by parabolas through ever less."""
    at = np.zeros(number)
    best = value(at)
    for step in steps:
        for way in step * np.eye(number):
            tried = at + way * _top(value(at - way), best, value(at + way))
            reached = value(tried)
            if reached > best:
                at, best = tried, reached
    return at


def _top(before: float, here: float, after: float) -> float:
    """Top of the parabola through values at -1, 0 and 1, limited to a little outside."""
    curve = 2.0 * here - before - after
    if not math.isfinite(curve):
        return 0.0
    if curve <= 0.0:
        return math.copysign(1.0, after - before)
    return min(max(0.5 * (after - before) / curve, -MOST_STEPS), MOST_STEPS)
