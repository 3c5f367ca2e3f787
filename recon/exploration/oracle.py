"""The oracle: a feasible tour of a known world, past three sides of every object."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial.distance import cdist

from recon.exploration.floor import Array, Floor, Mask, first_best
from recon.exploration.metrics import length_of
from recon.exploration.paths import is_clear, paths_over
from recon.exploration.routes import Order, improved, nearest_first
from recon.exploration.scales import Scales
from recon.world.objects import TrueObject

NUM_SIDES = 3
NUM_TURNS = 8
"""Number of rotations of an object's three sides that are tried."""
REACHES = (0.2, 0.35, 0.5, 0.75, 1.0)
"""Distances from an object that are tried, as shares of the viewing distance."""
NUM_ROUNDS = 8
"""Rounds of improving the stops and their order."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sides:
    """Positions around one object that show three sides of it, 120 degrees apart."""

    turns: tuple[tuple[Array, ...], ...]
    """For each rotation, the walkable positions (K, 2) of its sides."""

    @classmethod
    def of(cls, one: TrueObject, walkable: Mask, floor: Floor, viewing_distance: float) -> "Sides":
        """Find positions around an object; keeps the rotations with the most sides."""
        turn = 2.0 * math.pi / NUM_SIDES
        turns = []
        for start in np.linspace(0.0, turn, NUM_TURNS, endpoint=False):
            bearings = start + turn * np.arange(NUM_SIDES)
            sides = [_places(one, float(b), walkable, floor, viewing_distance) for b in bearings]
            turns.append(tuple(places for places in sides if len(places)))
        most = max(len(sides) for sides in turns)
        return cls(turns=tuple(sides for sides in turns if len(sides) == most))


def oracle_path(
    start_xz: Array, objects: Sequence[TrueObject], free: Mask, floor: Floor, scales: Scales
) -> float | None:
    """Length of a tour that a walker who knows the world could take; None if there is none.

    It begins at the start (2,), ends anywhere, keeps the walking clearance, and visits three sides
    of every object within the viewing distance. Order and positions are improved alternately
    (2-opt, and the best position between its neighbours); the length is that around the obstacles.

    Parameters
    ----------
    free : (X, Z) bool
        Floor cells outside the true footprints.
    floor : Floor
        Defines the grid of the cells.
    """
    room = np.full(free.shape, np.inf) if free.all() else distance_transform_edt(free)
    walkable = room >= scales.cells(scales.walk_clearance)
    walkable[tuple(floor.cells(start_xz))] = True
    # Ground that obstacles close in is walkable, but no way leads there.
    walkable &= np.isfinite(paths_over(floor, walkable, start_xz).distance)
    sides = [Sides.of(one, walkable, floor, scales.viewing_distance) for one in objects]
    if not all(one.turns[0] for one in sides):
        return None
    stops = [start_xz, *(side[0] for one in sides for side in one.turns[0])]
    order = nearest_first(_legs(stops))
    for _ in range(NUM_ROUNDS):
        stops = _moved(stops, order, sides)
        order = improved(order, _legs(stops))
    tour = [stops[number] for number in order]
    return sum(_walked(a, b, walkable, floor) for a, b in itertools.pairwise(tour))


def _places(
    one: TrueObject, bearing: float, walkable: Mask, floor: Floor, viewing_distance: float
) -> Array:
    """Walkable positions (K, 2) on one bearing of an object."""
    reach = max(one.size[[0, 2]]) / 2.0 + viewing_distance * np.array(REACHES)
    places = one.centre[[0, 2]] + np.outer(reach, [math.cos(bearing), math.sin(bearing)])
    cells = floor.flat(floor.cells(places))
    reached: Array = places[np.append(walkable.ravel(), False)[cells]]
    return reached


def _moved(stops: list[Array], order: Order, sides: Sequence[Sides]) -> list[Array]:
    """The stops, with each object's sides rotated and placed to minimise the tour."""
    stops, at = list(stops), {number: position for position, number in enumerate(order)}
    first = 1
    for one in sides:
        numbers = range(first, first + len(one.turns[0]))
        first += len(numbers)
        chosen = [_placed(stops, order, at, numbers, turn) for turn in one.turns]
        if chosen:
            for number, place in zip(numbers, min(chosen, key=lambda c: c[0])[1], strict=True):
                stops[number] = place
    return stops


def _placed(
    stops: list[Array], order: Order, at: dict[int, int], numbers: range, turn: tuple[Array, ...]
) -> tuple[float, list[Array]]:
    """Length that the best positions of one rotation add to the tour, and these positions."""
    total, places = 0.0, []
    for number, candidates in zip(numbers, turn, strict=True):
        position = at[number]
        beside = [stops[other] for other in order[position - 1 : position + 2] if other != number]
        added = sum(np.hypot(*(candidates - place).T) for place in beside)
        best = first_best(-np.asarray(added))
        total += float(np.asarray(added)[best])
        places.append(candidates[best])
    return total, places


def _legs(stops: list[Array]) -> Array:
    """Straight-line distances (N, N)."""
    return cdist(np.array(stops), np.array(stops))


def _walked(start: Array, end: Array, walkable: Mask, floor: Floor) -> float:
    """Length of the shortest path between two positions, with corners cut."""
    if is_clear(floor, walkable, start, end):
        return float(np.hypot(*(end - start)))
    paths = paths_over(floor, walkable, start)
    return length_of(np.vstack([start, paths.corners(end), end]))
