"""Ways between positions that a round may visit: straight, but round obstacles."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from recon.exploration.floor import Array
from recon.exploration.obstacles import Obstacle
from recon.exploration.scan import Detection

TINY = 1e-300
CLEARLY = 1.0 + 1e-9
"""Factor of the radius beyond which rounding does not matter."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ways:
    """The ways from here to some positions, and between these."""

    places: Array
    """(C, 2) x, z."""
    lengths: Array
    """(C,) lengths of the paths from here, world units."""
    discs: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(D, 3) centre and radius of the obstacles that the ways between them go round."""

    def to(self, place: int) -> Array:
        """Lengths (C,) of the ways from each position to one of them."""
        lengths: Array = lengths_between(self.places, self.places[place], self.discs)
        return lengths


def discs_of(obstacles: Iterable[Obstacle | Detection], clearance: float) -> Array:
    """Centre and radius (D, 3) of the discs that a walker does not enter."""
    rows = [(*one.centre, one.radius + clearance) for one in obstacles]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


@njit(cache=True)
def lengths_between(places: Array, end: Array, discs: Array) -> Array:
    """Length (C,) of the way from each position (C, 2) to another one (2,) round discs (D, 3).

    What every disc adds is added up, as if the others were not there.
    """
    lengths: Array = np.hypot(places[:, 0] - end[0], places[:, 1] - end[1])
    for number in range(len(discs)):
        _go_round(lengths, places, end, discs[number])
    return lengths


@njit(cache=True)
def _go_round(lengths: Array, places: Array, end: Array, disc: Array) -> None:
    """Add what going round a disc (3,) adds: two tangents and an arc instead of a straight line."""
    x, z, radius = disc
    end_x, end_z = end[0] - x, end[1] - z
    end_away = max(math.hypot(end_x, end_z), radius)
    for c in range(len(lengths)):
        own_x, own_z = places[c, 0] - x, places[c, 1] - z
        if _passes(own_x, own_z, end_x, end_z, radius):
            continue
        away = max(math.hypot(own_x, own_z), radius)
        between = abs(math.atan2(own_x * end_z - own_z * end_x, own_x * end_x + own_z * end_z))
        arc = between - math.acos(radius / away) - math.acos(radius / end_away)
        if arc > 0.0:
            straight = math.hypot(own_x - end_x, own_z - end_z)
            tangents = math.sqrt(away**2 - radius**2) + math.sqrt(end_away**2 - radius**2)
            lengths[c] += max(tangents + radius * arc - straight, 0.0)


@njit(cache=True)
def _passes(a_x: float, a_z: float, b_x: float, b_z: float, radius: float) -> bool:
    """True if a straight line from a to b passes clear of a disc about 0, as nearly all do."""
    by_x, by_z = b_x - a_x, b_z - a_z
    length_sq = by_x**2 + by_z**2
    share = min(max(-(a_x * by_x + a_z * by_z), 0.0), length_sq) / max(length_sq, TINY)
    near_x, near_z = a_x + share * by_x, a_z + share * by_z
    return bool(near_x**2 + near_z**2 > (radius * CLEARLY) ** 2)
