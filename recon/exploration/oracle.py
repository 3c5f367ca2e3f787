"""The oracle: a feasible tour of a known world, past three sides of every object."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial.distance import cdist

from recon.exploration.floor import Array, Floor, Mask, first_best
from recon.exploration.metrics import length_of
from recon.exploration.paths import is_clear, paths_over
from recon.exploration.scales import Scales
from recon.world.objects import TrueObject

NUM_SIDES = 3
NUM_TURNS = 8
"""Ways to turn the three sides of an object that are tried."""
REACHES = (0.2, 0.35, 0.5, 0.75, 1.0)
"""Shares of the viewing distance that are tried from an object's side."""
NUM_ROUNDS = 8
"""Times that the stops and their order are chosen anew."""

Order = list[int]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sides:
    """Places around one object that show three sides of it, a third of a turn apart."""

    turns: tuple[tuple[Array, ...], ...]
    """For each turn the places (K, 2) of its sides, those that can be stood on."""

    @classmethod
    def of(cls, one: TrueObject, walkable: Mask, floor: Floor, viewing_distance: float) -> "Sides":
        """Look for places around an object; of the turns, those with most sides are kept."""
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
    """Length of a tour that a walker who knows the world could go; None if there is none.

    It begins at the start (2,), ends anywhere, keeps the walking clearance, and stands on three
    sides of every object, from the viewing distance or nearer. Order and places are improved by
    turns (2-opt, and the best place for the neighbours); the length is that around the obstacles.

    Parameters
    ----------
    free : (X, Z) bool
        Floor cells outside the true footprints.
    floor : Floor
        Gives the grid of the cells.
    """
    room = np.full(free.shape, np.inf) if free.all() else distance_transform_edt(free)
    walkable = room >= scales.cells(scales.walk_clearance)
    walkable[tuple(floor.cells(start_xz))] = True
    sides = [Sides.of(one, walkable, floor, scales.viewing_distance) for one in objects]
    stops = [start_xz, *(side[0] for one in sides for side in one.turns[0])]
    order = nearest_first(_legs(stops))
    for _ in range(NUM_ROUNDS):
        stops = _moved(stops, order, sides)
        order = improved(order, _legs(stops))
    tour = [stops[number] for number in order]
    length = sum(_walked(a, b, walkable, floor) for a, b in itertools.pairwise(tour))
    return length if math.isfinite(length) else None


def _places(
    one: TrueObject, bearing: float, walkable: Mask, floor: Floor, viewing_distance: float
) -> Array:
    """(K, 2) walkable places on one bearing of an object."""
    reach = max(one.size[[0, 2]]) / 2.0 + viewing_distance * np.array(REACHES)
    places = one.centre[[0, 2]] + np.outer(reach, [math.cos(bearing), math.sin(bearing)])
    cells = floor.flat(floor.cells(places))
    reached: Array = places[np.append(walkable.ravel(), False)[cells]]
    return reached


def _moved(stops: list[Array], order: Order, sides: Sequence[Sides]) -> list[Array]:
    """The stops, each object's sides turned and placed so that the tour gets shortest."""
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
    """Length that the best places of one turn add to the tour, and these places."""
    total, places = 0.0, []
    for number, candidates in zip(numbers, turn, strict=True):
        position = at[number]
        beside = [stops[other] for other in order[position - 1 : position + 2] if other != number]
        added = sum(np.hypot(*(candidates - place).T) for place in beside)
        best = int(first_best(-np.asarray(added)))
        total += float(np.asarray(added)[best])
        places.append(candidates[best])
    return total, places


def _legs(stops: list[Array]) -> Array:
    """(N, N) distances as the crow flies."""
    return cdist(np.array(stops), np.array(stops))


def _walked(start: Array, end: Array, walkable: Mask, floor: Floor) -> float:
    """Length of the shortest path between two places, corners cut."""
    if is_clear(floor, walkable, start, end):
        return float(np.hypot(*(end - start)))
    paths = paths_over(floor, walkable, start)
    if not paths.reaches(end[None])[0]:
        return math.inf
    return length_of(np.vstack([start, paths.corners(end), end]))


def nearest_first(legs: Array) -> Order:
    """Order of a tour over N places that goes on to the nearest each time, from the first on."""
    order, left = [0], list(range(1, len(legs)))
    while left:
        order.append(min(left, key=lambda place: legs[order[-1], place]))
        left.remove(order[-1])
    return order


def improved(order: Order, legs: Array) -> Order:
    """The tour with stretches turned round as long as that shortens it (2-opt); its start stays."""
    tour = np.array(order)
    while (best := _best_turn(tour, legs)) is not None:
        i, j = best
        tour[i : j + 1] = tour[i : j + 1][::-1]
    return [int(number) for number in tour]


def _best_turn(tour: NDArray[np.intp], legs: Array) -> tuple[int, int] | None:
    """First and last position of the stretch that shortens the tour most; None if none does."""
    number = len(tour)
    if number < 3:
        return None
    before, here = tour[:-1], tour[1:]
    after = np.append(tour[2:], -1)
    ahead = np.where(after >= 0, legs[here, after], 0.0)
    gain = legs[before, here][:, None] + ahead
    gain -= legs[np.ix_(before, here)] + np.where(after >= 0, legs[np.ix_(here, after)], 0.0)
    gain = np.triu(gain, k=1)
    i, j = np.unravel_index(int(gain.argmax()), gain.shape)
    return (int(i) + 1, int(j) + 1) if gain[i, j] > 1e-9 * legs.max() else None
