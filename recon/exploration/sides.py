"""Sides of obstacles: the unseen ones, and the views that would show them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.exploration.floor import Array, Floor, Mask
from recon.exploration.gains import AZIMUTHS_RAD, SPACING_RAD, turn
from recon.exploration.gaps import values_of
from recon.exploration.obstacles import Obstacle
from recon.exploration.scan import Detection
from recon.exploration.search import Look, Search, Wanted
from recon.exploration.sight import are_open

OPEN_SURE_RAD, OPEN_RAD = math.radians(150.0), math.radians(110.0)
"""An obstacle is known if no gap between its views is wider, with and without a sure label: three
or four views all around."""
MARGIN_RAD = math.radians(8.0)
"""Views are planned closer together by this angle, since positions are never reached exactly."""
BEARINGS_RAD: Array = 2.0 * math.pi * (np.arange(72) + 0.5) / 72
CENTRED = 0.1
"""Share of its value that an obstacle loses at the edge of the image."""
Seen = tuple[Array, Array, Array]
"""`azimuth`, `slack` and `arc` of some sides."""
Left = tuple[Mask, Array, Array]
"""`missing`, `shown` and `worth` of some sides."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sides:
    """The sides of O obstacles, as seen from C positions."""

    obstacles: Wanted
    places: Array
    """(C, 2) x, z."""
    azimuth: Array
    """(O, C) direction of each obstacle."""
    slack: Array
    """(O, C) angle by which a view may miss its centre; negative if it is not seen."""
    arc: Array
    """(O,) half the arc of bearings that one view covers."""
    missing: Mask
    """(O, BEARINGS) bearings that no view covers."""
    shown: Array
    """Share (O, C) of a side of each obstacle that would become known."""
    worth: Array
    """Number (C, NUM_RAYS) of sides that a view along each azimuth would cover."""

    @classmethod
    def of(
        cls,
        wanted: Wanted,
        places: Array,
        floor: Floor,
        field_rad: float,
        search: Search,
    ) -> "Sides":
        """The sides of obstacles within reach of positions (C, 2) that a search has to see."""
        centres = np.array([one.centre for one in wanted]).reshape(-1, 2)
        radii = np.array([one.radius for one in wanted]).reshape(-1, 1)
        x, z = np.moveaxis(centres[:, None] - places, -1, 0)
        azimuth, apart = np.arctan2(z, x), np.hypot(x, z)
        is_near = (apart - radii <= search.reach) & (apart > 0.0)
        is_near &= (search.least == 0.0) | (apart - radii >= search.least)
        own = (radii[:, 0] + floor.cell_size) / floor.cell_size
        lines = (floor.in_cells(places), floor.in_cells(centres), own)
        is_seen = are_open(floor.occupied, *lines, is_near)
        half_width = np.arcsin(np.minimum(radii / np.where(is_near, apart, np.inf), 1.0))
        slack = np.where(is_seen, np.maximum(field_rad / 2.0 - half_width, SPACING_RAD), -1.0)
        arc, looked = np.array([_arc(one, search) for one in wanted]), _looked(search.looks)
        of_each = [_missing(one, looked, search) for one in wanted]
        missing = np.array(of_each, dtype=bool).reshape(len(wanted), len(BEARINGS_RAD))
        shown = _shown(azimuth, slack, missing, arc)
        worth = np.zeros((len(places), len(AZIMUTHS_RAD)))
        _add_up(worth, np.arange(len(places)), shown, azimuth, slack)
        return cls(
            obstacles=wanted,
            places=places,
            azimuth=azimuth,
            slack=slack,
            arc=arc,
            missing=missing,
            shown=shown,
            worth=worth,
        )

    def after(self, place: int, azimuth_rad: float) -> "tuple[Sides, NDArray[np.intp]]":
        """The sides left after a view, and the positions from which less is left to see."""
        missing, shown, worth = self.missing.copy(), self.shown.copy(), self.worth.copy()
        changed = _cover(
            (self.azimuth, self.slack, self.arc), (missing, shown, worth), place, azimuth_rad
        )
        return replace(self, missing=missing, shown=shown, worth=worth), changed

    def looks(self, place: int, azimuth_rad: float) -> list[Look]:
        """The looks at obstacles of which a view from a position would show something new."""
        shown = self.shown[:, place]
        return [
            Look(place=self.places[place], centre=self.obstacles[row].centre)
            for row in self._in_view(place, azimuth_rad)
            if shown[row] > 0.0
        ]

    def target(self, place: int, azimuth_rad: float) -> Obstacle | Detection | None:
        """The obstacle in the centre of a view that would show something new of it."""
        shown = self.shown[:, place]
        ahead = turn(self.azimuth[:, place], np.array(azimuth_rad)) <= 0.75 * SPACING_RAD
        rows = np.flatnonzero(ahead & (shown > 0.0))
        return self.obstacles[rows[shown[rows].argmax()]] if len(rows) else None

    def _in_view(self, place: int, azimuth_rad: float) -> NDArray[np.intp]:
        """Rows of the obstacles within the field of a view from a position."""
        miss = turn(self.azimuth[:, place], np.array(azimuth_rad))
        return np.flatnonzero(miss <= self.slack[:, place])


def is_known(obstacle: Obstacle) -> bool:
    """True if an obstacle was seen from enough sides for its label and its map."""
    return widest_gap(obstacle.bearings_rad) <= (OPEN_SURE_RAD if obstacle.is_sure else OPEN_RAD)


def is_given_up(obstacle: Obstacle | Detection, search: Search) -> bool:
    """True if all sides of an obstacle that no view showed well were looked at in vain."""
    return not _missing(obstacle, _looked(search.looks), search).any()


def widest_gap(bearings_rad: Array) -> float:
    """The widest angle between neighbouring directions (V,); a full turn for one or none."""
    ordered: list[float] = sorted(np.mod(bearings_rad, 2.0 * math.pi).tolist())
    if not ordered:
        return 2.0 * math.pi
    following = [*ordered[1:], ordered[0] + 2.0 * math.pi]
    return max(after - before for before, after in zip(ordered, following, strict=True))


def _planned_gap(obstacle: Obstacle | Detection, search: Search) -> float:
    """The gap that views may leave; an obstacle not yet named gets the expected kind of label."""
    is_sure = search.expects_names
    if isinstance(obstacle, Obstacle) and obstacle.found is not None:
        is_sure = obstacle.is_sure
    return OPEN_SURE_RAD if is_sure else OPEN_RAD


def _arc(obstacle: Obstacle | Detection, search: Search) -> float:
    """Half the arc of bearings that one view of an obstacle covers.

    A detection less certain than the distance from which it would be viewed has no sides yet: one
    view from nearby tells where it is, or that nothing is there.
    """
    if isinstance(obstacle, Detection) and obstacle.sigma > search.clearance:
        return math.pi
    return (_planned_gap(obstacle, search) - MARGIN_RAD) / 2.0


def _looked(looks: Sequence[Look]) -> Array:
    """Centre and position (L, 2, 2) of each look."""
    return np.array([(*look.centre, *look.place) for look in looks]).reshape(-1, 2, 2)


def _missing(obstacle: Obstacle | Detection, looks: Array, search: Search) -> Mask:
    """Mask (BEARINGS,) of bearings not within an arc of one seen well or looked at in vain.

    Parameters
    ----------
    looks : (L, 2, 2)
        Centre and position of each look so far.
    """
    arc = _arc(obstacle, search)
    seen = obstacle.bearings_rad if isinstance(obstacle, Obstacle) else np.empty(0)
    offsets = looks - obstacle.centre
    x, z = offsets[np.hypot(*offsets[:, 0].T) <= obstacle.radius, 1].T
    looked = np.arctan2(z, x)
    is_seen = turn(BEARINGS_RAD[:, None], seen) <= arc
    num_looks = (turn(BEARINGS_RAD[:, None], looked) <= arc).sum(axis=1)
    missing: Mask = ~(is_seen.any(axis=1) | (num_looks >= search.max_looks))
    return missing


@njit(cache=True)
def _apart(a_rad: float, b_rad: float) -> float:
    """Smallest angle between two directions."""
    away = abs(a_rad - b_rad) % (2.0 * math.pi)
    return min(away, 2.0 * math.pi - away)


@njit(cache=True)
def _shown(azimuth: Array, slack: Array, missing: Mask, arc: Array) -> Array:
    """Share (O, C) of a side of each obstacle that views from each position would cover."""
    shown = np.zeros(azimuth.shape)
    for row in range(azimuth.shape[0]):
        _show(azimuth[row], slack[row], missing[row], arc[row], shown[row])
    return shown


@njit(cache=True)
def _show(azimuth: Array, slack: Array, missing: Mask, arc: float, shown: Array) -> None:
    """Set what is `shown` (C,) of one obstacle from each position."""
    number, half = len(BEARINGS_RAD), arc * len(BEARINGS_RAD) / (2.0 * math.pi)
    values = values_of(missing, 2.0 * half)
    for c in range(len(azimuth)):
        shown[c] = 0.0
        if slack[c] >= 0.0:
            # Bearings are half a spacing off the multiples of it.
            middle = (azimuth[c] / (2.0 * math.pi) + 0.5) % 1.0 * number - 0.5
            first, last = math.ceil(middle - half), math.floor(middle + half)
            shown[c] = values[last - first + 1 - int(2.0 * half), first % number]


@njit(cache=True)
def _cover(seen: Seen, left: Left, place: int, azimuth_rad: float) -> NDArray[np.intp]:
    """Remove the sides that a view from a position shows from what is `left`, in place.

    Returns
    -------
    (K,) int
        The positions from which less is left to see.
    """
    azimuth, slack, arc = seen
    missing, shown, worth = left
    changed = np.zeros(shown.shape[1], np.bool_)
    for row in range(len(arc)):
        if _apart(azimuth[row, place], azimuth_rad) <= slack[row, place]:
            before, behind = shown[row].copy(), azimuth[row, place] + math.pi
            for number in range(len(BEARINGS_RAD)):
                missing[row, number] &= _apart(BEARINGS_RAD[number], behind) > arc[row]
            _show(azimuth[row], slack[row], missing[row], arc[row], shown[row])
            changed |= shown[row] != before
    places = np.flatnonzero(changed)
    _add_up(worth, places, shown, azimuth, slack)
    return places


@njit(cache=True)
def _add_up(
    worth: Array, places: NDArray[np.intp], shown: Array, azimuth: Array, slack: Array
) -> None:
    """Sum what is shown (O, C) from some positions along the rays (C, NUM_RAYS) with it in view."""
    for c in places:
        worth[c] = 0.0
        for row in range(shown.shape[0]):
            if shown[row, c] > 0.0:
                _add(worth[c], shown[row, c], azimuth[row, c], slack[row, c])


@njit(cache=True)
def _add(worth: Array, shown: float, azimuth: float, slack: float) -> None:
    """Add what is shown of one obstacle to the rays (NUM_RAYS,) with it in the field."""
    half = int(slack / SPACING_RAD) + 1
    first = math.floor(azimuth / SPACING_RAD) - half
    for number in range(first, first + min(2 * half + 2, len(AZIMUTHS_RAD))):
        ray = number % len(AZIMUTHS_RAD)
        miss = _apart(azimuth, AZIMUTHS_RAD[ray]) / slack
        if miss <= 1.0:
            worth[ray] += shown * (1.0 - CENTRED * miss**2)
