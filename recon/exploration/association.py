"""Association of the objects in view with the landmarks of a graph.

All objects of a pair share the errors of its pose: together they tell which is which where each
alone might be several (joint compatibility, Neira and Tardos 2001). What remains ambiguous is left
open.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from recon.exploration.landmarks import GATE, Sighter
from recon.exploration.outlines import Outline
from recon.geometry import wrapped

FAR_GATE = 4.0
"""Standard deviations beyond which an object is not a landmark."""
PROBABILITY = 0.99
"""Of the joint error of all objects, up to which their landmarks may be right."""
MARGIN = 10.0
"""Squared standard deviations by which all other landmarks must be worse."""
MAX_WAYS = 500
"""Maximum number of ways in which the objects of a pair are associated together."""
SAME_DISTANCE = 1.5
"""Two objects in one direction differ in distance by more than this factor."""
NEW, UNCLEAR = -1, -2

Way = tuple[int, ...]
"""The landmark of each object, or UNCLEAR."""


def associated(sighter: Sighter, seen: Sequence[Outline]) -> list[int]:
    """The landmark of each object, NEW, or UNCLEAR."""
    allowed = [_allowed(sighter, one) for one in seen]
    ways = _ways(allowed)
    found = _agreed(sighter, seen, ways) if ways else (UNCLEAR,) * len(seen)
    return [
        NEW if landmark == UNCLEAR and not of and _is_new(sighter, one) else landmark
        for one, landmark, of in zip(seen, found, allowed, strict=True)
    ]


def _allowed(sighter: Sighter, one: Outline) -> list[int]:
    """The landmarks that an object may be."""
    return [
        landmark
        for landmark in range(len(sighter.graph.radii))
        if sighter.is_as_wide(one, landmark) and np.hypot(*sighter.off(one, landmark)) < GATE
    ]


def _ways(allowed: list[list[int]]) -> list[Way]:
    """All ways to associate; none if there are too many."""
    if math.prod(len(one) + 1 for one in allowed) > MAX_WAYS:
        return []
    return [way for way in itertools.product(*([*one, UNCLEAR] for one in allowed)) if _fits(way)]


def _fits(way: Way) -> bool:
    """True if no landmark is two objects."""
    known = _known(way)
    return len({*known}) == len(known)


def _known(way: Way) -> list[int]:
    return [landmark for landmark in way if landmark != UNCLEAR]


def _agreed(sighter: Sighter, seen: Sequence[Outline], ways: list[Way]) -> Way:
    """The associations that all likely ways of associating most objects have in common."""
    for number in range(len(seen), 0, -1):
        most = [way for way in ways if len(_known(way)) == number]
        errors = np.array([sighter.joint_error(seen, way) for way in most])
        if len(most) and errors.min() < chdtri(2 * number, 1.0 - PROBABILITY):
            likely = [most[row] for row in np.flatnonzero(errors < errors.min() + MARGIN)]
            return tuple(of[0] if len({*of}) == 1 else UNCLEAR for of in zip(*likely, strict=True))
    return (UNCLEAR,) * len(seen)


def _is_new(sighter: Sighter, one: Outline) -> bool:
    return all(_is_other(sighter, one, number) for number in range(len(sighter.graph.radii)))


def _is_other(sighter: Sighter, seen: Outline, landmark: int) -> bool:
    """True if an object is beside a landmark, or clearly in front of it or behind it."""
    expected, off = sighter.expected, sighter.off(seen, landmark)
    ratio = seen.distance / max(float(expected.front[landmark]), 1e-6)
    if float(np.hypot(*off)) > FAR_GATE and abs(math.log(ratio)) > math.log(SAME_DISTANCE):
        return True
    spread = float(expected.spread(landmark, sighter.joint)[0, 0])
    reach = seen.half_rad + expected.half_rad[landmark] + FAR_GATE * math.sqrt(spread)
    apart = wrapped(seen.middle_rad - expected.azimuth_rad[landmark])
    return bool(abs(apart) > reach)
