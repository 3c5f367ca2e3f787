"""Where the agent can walk, and its shortest ways."""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt, label
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull

from recon.exploration.floor import NEIGHBOURS, RAY_SPACING, Array, Floor, Mask
from recon.exploration.sight import Sighting
from recon.exploration.state import State, Walk
from recon.exploration.things import Thing

STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))
"""To four of a cell's eight neighbours; the others are the same edges from the other end."""
GAZE = 20.0
"""How far ahead the eyes meet when they look at nothing, world units."""
CLOSER = (1.0, 0.8, 0.6, 0.4, 1.2, 1.4)
"""Factors of the distance that is tried round a thing."""
FRONTIER_BLOCK, OPEN_BLOCK = 8, 16
"""Places are tried one a square of so many cells."""
BORDER = 4
"""Cells between the unknown and a place to look at it from: the clearance, in cells."""
UNKNOWN_CLEARANCE = 2.0
"""World units kept from unknown ground: the side of a thing that nobody saw may begin there."""
MIN_POCKET = 10
"""Unknown patches of fewer cells are chinks between rays, not places to go and see."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ways:
    """Shortest ways over the floor from one place to all others."""

    floor: Floor
    walkable: Mask
    """(X, Z) known free and far enough from everything."""
    place: Array
    """(2,) x, z where the ways begin."""
    distance: Array
    """(X, Z) length of the way, world units; infinite where there is none."""
    _before: NDArray[np.int32]
    """(X * Z,) the cell before each cell on its way."""

    def reaches(self, points_xz: Array) -> Mask:
        """(N,) which points (N, 2) can be walked to."""
        return np.isfinite(self.length(points_xz))

    def length(self, points_xz: Array) -> Array:
        """(N,) length of the way to each point; infinite where there is none."""
        lengths = np.append(self.distance.ravel(), np.inf)
        return lengths[self.floor.flat(self.floor.cells(points_xz))]

    def nearest(self, point_xz: Array) -> Array:
        """The reachable place (2,) nearest to a point."""
        places = self.floor.centres(np.argwhere(np.isfinite(self.distance)))
        nearest: Array = places[np.hypot(*(places - point_xz).T).argmin()]
        return nearest

    def is_clear(self, start_xz: Array, end_xz: Array) -> bool:
        """Whether the straight line between two points can be walked."""
        number = 2 + int(np.hypot(*(end_xz - start_xz)) / RAY_SPACING)
        share = np.linspace(0.0, 1.0, number)[:, None]
        cells = self.floor.cells(start_xz + share * (end_xz - start_xz))
        return bool(np.append(self.walkable.ravel(), False)[self.floor.flat(cells)].all())

    def corners(self, end_xz: Array) -> Array:
        """Corners (N, 2) of the way to a point that can be reached, its ends left out.

        The way over the cells is pulled straight wherever the straight line can be walked.
        """
        steps = [*self._cells_to(end_xz), end_xz]
        corners: list[Array] = []
        anchor = self.place
        for here, ahead in itertools.pairwise(steps):
            if not self.is_clear(anchor, ahead):
                corners.append(here)
                anchor = here
        return np.array(corners).reshape(-1, 2)

    def _cells_to(self, end_xz: Array) -> list[Array]:
        """Middles of the cells on the way, in order, without the first and the last."""
        cell = int(self.floor.flat(self.floor.cells(end_xz)))
        cells = []
        while (cell := int(self._before[cell])) >= 0:
            cells.append(self.floor.centres(np.array(np.unravel_index(cell, self.walkable.shape))))
        return cells[-2::-1]


def plan(state: State, *, through_unknown: bool = False) -> Ways:
    """The ways from where the agent stands: A* to all cells at once, which is Dijkstra's search.

    With `through_unknown`, ground that nobody has seen yet is taken for free.
    """
    floor = state.floor
    walkable = _walkable(state, through_unknown)
    start = int(floor.flat(floor.cells(state.place)))
    distance, before = dijkstra(
        _graph(walkable), directed=False, indices=[start], return_predecessors=True
    )
    return Ways(
        floor=floor,
        walkable=walkable,
        place=state.place,
        distance=distance[0].reshape(floor.shape),
        _before=before[0],
    )


def _walkable(state: State, through_unknown: bool) -> Mask:
    """Free cells that keep the clearance.

    Where the agent itself stands too near to something, it may stay as near while it gets away.
    """
    floor, clearance = state.floor, state.settings.exploration.walk_clearance
    here = tuple(floor.cells(state.place))
    things = floor.occupied.copy()
    for sighting in state.sightings:
        things |= floor.disc(sighting.centre, sighting.radius)
    walkable = ~things & _away_from(things, clearance, here)
    if not through_unknown:
        unknown = unexplored(floor, state.things)
        walkable &= floor.known_free & _away_from(unknown, UNKNOWN_CLEARANCE, here)
    walkable[here] = True
    return walkable


def _away_from(cells: Mask, clearance: float, here: tuple[int, ...]) -> Mask:
    """(X, Z) cells that keep a clearance, but near `here` no more than is kept there."""
    if not cells.any():
        return np.ones_like(cells)
    room = distance_transform_edt(~cells)
    offset = np.indices(cells.shape) - np.reshape(here, (2, 1, 1))
    close = np.hypot(*offset) <= 2.0 * clearance
    away: Mask = room >= np.where(close, min(clearance, float(room[here])), clearance)
    return away


def _graph(walkable: Mask) -> "csr_array[np.float64, tuple[int, int]]":
    """Lengths between neighbouring walkable cells."""
    number = np.arange(walkable.size).reshape(walkable.shape)
    ends, lengths = [], []
    for dx, dz in STEPS:
        one = (slice(0, walkable.shape[0] - dx), slice(max(0, -dz), walkable.shape[1] - max(0, dz)))
        other = (slice(dx, None), slice(max(0, dz), walkable.shape[1] - max(0, -dz)))
        both = walkable[one] & walkable[other]
        ends.append(np.stack([number[one][both], number[other][both]]))
        lengths.append(np.full(both.sum(), np.hypot(dx, dz)))
    a, b = np.concatenate(ends, axis=1)
    return csr_array((np.concatenate(lengths), (a, b)), shape=(walkable.size, walkable.size))


def azimuth_of(direction_xz: Array) -> float:
    """Azimuth of a direction (2,) x, z."""
    return math.atan2(direction_xz[1], direction_xz[0])


def lifted(points_xz: Array, height: float) -> Array:
    """Points (..., 3) over the floor points (..., 2)."""
    x, z = np.moveaxis(points_xz, -1, 0)
    return np.stack([x, np.full_like(x, height), z], axis=-1)


def look_along(ways: Ways, place: Array, azimuth_rad: float, state: State) -> Walk:
    """The view from a place (2,) that can be reached, level into a direction."""
    ahead = place + GAZE * np.array([math.cos(azimuth_rad), math.sin(azimuth_rad)])
    return look_to(ways, place, lifted(ahead, state.settings.eyes.eye_height), state)


def look_at(ways: Ways, place: Array, thing: Thing | Sighting, state: State) -> Walk:
    """The view from a place (2,) that can be reached on the middle of a thing."""
    return look_to(ways, place, middle_of(thing, state), state)


def look_to(ways: Ways, place: Array, target: Array, state: State) -> Walk:
    """The view from a place (2,) that can be reached on a target (3,)."""
    height = state.settings.eyes.eye_height
    return Walk(
        position=lifted(place, height),
        target=target,
        via=lifted(ways.corners(place), height),
    )


def middle_of(thing: Thing | Sighting, state: State) -> Array:
    """The point (3,) to look at of a thing; not below the eyes, so that the gaze stays level."""
    height = state.settings.eyes.eye_height
    middle = max(height, thing.top / 2.0) if isinstance(thing, Thing) else height
    return lifted(thing.centre, middle)


def unexplored(floor: Floor, things: Iterable[Thing]) -> Mask:
    """(X, Z) unknown cells worth a look: not the insides of things, no chinks."""
    unknown = ~floor.known_free & ~floor.occupied
    for thing in things:
        unknown &= ~_inside(floor, thing.cells)
    number, _ = label(unknown, NEIGHBOURS)
    large = np.bincount(number.ravel()) >= MIN_POCKET
    large[0] = False
    return large[number]


def _inside(floor: Floor, cells: NDArray[np.intp]) -> Mask:
    """(X, Z) cells whose middle lies in the convex hull of some cells."""
    square = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
    hull = ConvexHull((cells[:, None] + square).reshape(-1, 2))
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    box = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1)
    inside = np.zeros(floor.shape, dtype=bool)
    signed = (box + 0.5) @ hull.equations[:, :2].T + hull.equations[:, 2]
    inside[low[0] : high[0], low[1] : high[1]] = (signed <= 1e-9).all(axis=-1)
    return inside


def lookouts(ways: Ways, unknown: Mask) -> Array:
    """Places (N, 2) that can be reached and are worth looking round from.

    The frontier, which is the cells that border on unknown ones but for the ground along things,
    on which the agent does not walk; and places all over the known ground, as much of the unknown
    is seen from afar.
    """
    reached = np.isfinite(ways.distance)
    border = binary_dilation(unknown, NEIGHBOURS, iterations=BORDER)
    frontier = _one_a_block(np.argwhere(reached & border), ways.distance, FRONTIER_BLOCK)
    open_ground = _one_a_block(np.argwhere(reached), ways.distance, OPEN_BLOCK)
    return ways.floor.centres(np.vstack([frontier, open_ground]))


def _one_a_block(cells: NDArray[np.intp], distance: Array, block: int) -> NDArray[np.intp]:
    """The nearest of the cells (N, 2) in each square of block x block cells."""
    number = cells // block @ np.array([1 + distance.shape[1] // block, 1])
    nearest_first = np.lexsort((distance[tuple(cells.T)], number))
    _, first = np.unique(number[nearest_first], return_index=True)
    return cells[nearest_first[first]]


def stand(
    ways: Ways, thing: Thing | Sighting, bearing_rad: float, clearance: float
) -> Array | None:
    """Where (2,) to look at a thing from on one bearing; None where no place can be reached.

    Where something stands in the way, the distance is shortened, then lengthened.
    """
    direction = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    places = thing.centre + np.outer(thing.radius + clearance * np.array(CLOSER), direction)
    reached = np.flatnonzero(ways.reaches(places))
    place: Array | None = places[reached[0]] if len(reached) else None
    return place
