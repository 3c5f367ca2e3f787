"""A round of views past what is left to see, built by cheapest insertion and then reordered."""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.exploration.floor import ROUNDING, Array, Mask, first_best
from recon.exploration.gains import AZIMUTHS_RAD, Visibility
from recon.exploration.routes import shortest
from recon.exploration.scales import Scales
from recon.exploration.sides import Sides
from recon.exploration.sight import update_best
from recon.exploration.ways import Ways

MAX_OBJECT_STOPS, MAX_GROUND_STOPS = 24, 8
"""Maximum number of stops of a round: further ones hardly change where it begins."""
MAX_UNKNOWN = 0.02
"""Maximum share of unseen floor in corners when everything counts as known."""
EARLY = 3.0
"""Ground beside the path to objects waits until after them, unless visiting it on the way costs
less by this factor."""


@dataclass(slots=True, kw_only=True)
class Tour:
    """An open path from here past some of C positions."""

    ways: Ways
    stops: list[tuple[int, int]] = field(default_factory=list)
    """Indices of the position and the ray of each view, in order."""
    _legs: list[Array] = field(default_factory=list)
    """Distances (C,) of the positions from each stop."""

    def insert(self, position: int, place: int, ray: int) -> None:
        """Insert a view before the stop at an index of the path."""
        self.stops.insert(position, (place, ray))
        self._legs.insert(position, self.ways.to(place))

    def detours(self, early: float = 1.0) -> tuple[Array, NDArray[np.intp]]:
        """The detour (C,) that each position adds to the path, and its index (C,) on the path.

        Parameters
        ----------
        early : float
            Factor for detours that are not at the path's end.
        """
        lengths = self.ways.lengths
        if not self.stops:
            return lengths, np.zeros(len(lengths), dtype=np.intp)
        found: tuple[Array, NDArray[np.intp]] = _detours(
            lengths, np.array(self._legs), np.array([place for place, _ in self.stops]), early
        )
        return found

    def shorten(self) -> None:
        """Put the stops into the order of the shortest path."""
        numbers = [place for place, _ in self.stops]
        legs = np.zeros((len(numbers) + 1, len(numbers) + 1))
        legs[0, 1:] = legs[1:, 0] = self.ways.lengths[numbers]
        legs[1:, 1:] = np.reshape(self._legs, (len(numbers), len(self.ways.places)))[:, numbers]
        order = shortest(legs)[1:]
        self.stops = [self.stops[number - 1] for number in order]
        self._legs = [self._legs[number - 1] for number in order]


@njit(cache=True)
def _detours(
    lengths: Array, legs: Array, stops: NDArray[np.intp], early: float
) -> tuple[Array, NDArray[np.intp]]:
    """Smallest detour (C,) and its position (C,) on a path past some of C positions.

    Parameters
    ----------
    lengths, legs : (C,), (S, C)
        Distances of the positions from the start of the path and from its stops.
    stops : (S,)
        Positions of the stops.
    """
    last = len(stops) - 1
    detour, position = legs[last].copy(), np.full(len(lengths), last + 1)
    for stop in range(last, -1, -1):
        before = lengths if stop == 0 else legs[stop - 1]
        along = before[stops[stop]]
        for c in range(len(lengths)):
            between = max(early * (before[c] + legs[stop, c] - along), 0.0)
            # Of detours equal up to rounding, the first is taken.
            if between <= detour[c] + ROUNDING * lengths[c]:
                detour[c], position[c] = min(between, detour[c]), stop
    return detour, position


def first_stop(
    ways: Ways,
    visibility: Visibility,
    sides: Sides,
    unknown: Mask,
    scales: Scales,
    reached: Mask,
) -> tuple[int, float] | None:
    """Index of the position and azimuth of the first view of a round.

    Repeatedly inserts the view that shows most for its detour where the detour is shortest and
    marks what it would show as seen, until no view shows enough: first sides of obstacles, whose
    order is then improved, and then ground on the way and after. None if nothing is left.

    Parameters
    ----------
    ways : Ways
        The ways to the positions of `visibility` and `sides`.
    unknown : (X, Z) bool
        Ground to be seen.
    reached : (C,) bool
        The positions from which ground may be looked at, sides of obstacles from all.
    """
    tour = Tour(ways=ways)
    add_objects(tour, visibility, sides, unknown, scales)
    tour.shorten()
    for place, ray in tour.stops:
        unknown = visibility.left(unknown, ways.places[place], AZIMUTHS_RAD[ray])
    add_ground(tour, visibility.only(reached), unknown, scales)
    if not tour.stops:
        return None
    place, ray = tour.stops[0]
    return place, float(AZIMUTHS_RAD[ray])


def add_objects(
    tour: Tour, visibility: Visibility, sides: Sides, unknown: Mask, scales: Scales
) -> None:
    """Insert views of new sides of obstacles into a round; ground in these views counts too."""
    if not sides.missing.any():
        return
    changed = np.flatnonzero(sides.shown.any(axis=0))
    area = visibility.area(unknown, changed)
    ground = scales.much_area * area / (area + scales.much_area)
    most, ray = np.zeros(len(area)), np.zeros(len(area), dtype=np.intp)
    for _ in range(MAX_OBJECT_STOPS):
        update_best((most, ray), changed, sides.worth, ground, visibility.barred, scales.side_area)
        detour, position = tour.detours()
        score = most / (detour + scales.pair_cost)
        best = first_best(score)
        if score[best] == 0.0:
            return
        tour.insert(int(position[best]), best, int(ray[best]))
        sides, changed = sides.after(best, AZIMUTHS_RAD[ray[best]])


def add_ground(tour: Tour, visibility: Visibility, unknown: Mask, scales: Scales) -> None:
    """Insert views of unknown ground into a round.

    If little is unknown, a view is only worth a detour of at most one viewing distance per minimum
    area that it shows.
    """
    is_little = unknown.mean() <= MAX_UNKNOWN
    least_rate = scales.min_area / scales.viewing_distance if is_little else 0.0
    early = EARLY if tour.stops else 1.0
    best = visibility.best(unknown)
    for _ in range(MAX_GROUND_STOPS):
        detour, position = tour.detours(early)
        least = np.maximum(scales.min_area, least_rate * detour)
        stop = visibility.best_place(unknown, best, detour + scales.stop_cost, least)
        if stop is None:
            return
        tour.insert(int(position[stop[0]]), *stop)
        place, azimuth = tour.ways.places[stop[0]], float(AZIMUTHS_RAD[stop[1]])
        unknown = visibility.left(unknown, place, azimuth)
        visibility = visibility.without([(place, azimuth)], scales.same_place)
