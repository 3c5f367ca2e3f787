"""Shortest paths over the floor that keep away from obstacles and unknown ground."""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import label

from recon.exploration.floor import NEIGHBOURS, RAY_SPACING, Array, Floor, Mask
from recon.exploration.obstacles import Obstacle
from recon.exploration.state import State
from recon.exploration.wave import shortest

DIGITS = 9
"""Decimals of lengths in cells: the same steps in another order have equal length."""
MIN_POCKET = 10
"""Unknown patches of fewer cells are gaps between rays and not worth a look."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShortestPaths:
    """Shortest paths over the floor from one position to all others."""

    floor: Floor
    walkable: Mask
    """(X, Z) known to be free and far enough from everything."""
    place: Array
    """(2,) x, z of the start of the paths."""
    distance: Array
    """(X, Z) length of the path, world units; infinite if there is none."""
    _before: NDArray[np.int32]
    """(X, Z, 2) the previous cell of each cell on its path."""

    def reaches(self, points_xz: Array) -> Mask:
        """Mask (...,) of the reachable points (..., 2)."""
        return np.isfinite(self.length(points_xz))

    def length(self, points_xz: Array) -> Array:
        """Length (...,) of the path to each point (..., 2); infinite if there is none."""
        lengths = np.append(self.distance.ravel(), np.inf)
        return lengths[self.floor.flat(self.floor.cells(points_xz))]

    def nearest(self, point_xz: Array) -> Array:
        """The reachable position (2,) nearest to a point."""
        places = self.floor.centres(np.argwhere(np.isfinite(self.distance)))
        nearest: Array = places[np.hypot(*(places - point_xz).T).argmin()]
        return nearest

    def is_clear(self, start_xz: Array, end_xz: Array) -> bool:
        """True if the straight line between two points can be walked."""
        return is_clear(self.floor, self.walkable, start_xz, end_xz)

    def corners(self, end_xz: Array) -> Array:
        """Corners (N, 2) of the path to a reachable point, without its ends.

        The path over the cells is straightened where the straight line can be walked.
        """
        steps = [*self.cells_to(end_xz), end_xz]
        corners: list[Array] = []
        anchor = self.place
        for here, ahead in itertools.pairwise(steps):
            if not self.is_clear(anchor, ahead):
                corners.append(here)
                anchor = here
        return np.array(corners).reshape(-1, 2)

    def cells_to(self, end_xz: Array) -> list[Array]:
        """Centres of the cells on the path, in order, without the first and the last."""
        first, cells = tuple(self.floor.cells(self.place)), []
        cell = tuple(self.floor.cells(end_xz))
        while cell != first:
            cells.append(self.floor.centres(cell))
            cell = tuple(self._before[cell])
        return cells[:0:-1]


def is_clear(floor: Floor, walkable: Mask, start_xz: Array, end_xz: Array) -> bool:
    """True if the straight line between two points stays on walkable cells (X, Z)."""
    number = 2 + int(np.hypot(*(end_xz - start_xz)) / (RAY_SPACING * floor.cell_size))
    share = np.linspace(0.0, 1.0, number)[:, None]
    cells = floor.cells(start_xz + share * (end_xz - start_xz))
    return bool(np.append(walkable.ravel(), False)[floor.flat(cells)].all())


def plan(state: State, unknown: Mask | None) -> ShortestPaths:
    """Find the paths from the agent's position to all cells at once.

    Paths stay away from the cells `unknown` (X, Z), which are the `unexplored` ones; with None,
    ground that has not been seen is treated as free.
    """
    return paths_over(state.floor, _walkable(state, unknown), state.place)


def paths_over(floor: Floor, walkable: Mask, place: Array) -> ShortestPaths:
    """Find the paths from a position (2,) over the walkable cells (X, Z) to all others."""
    x, z = floor.cells(place)
    distance, before = shortest(walkable, (int(x), int(z)))
    return ShortestPaths(
        floor=floor,
        walkable=walkable,
        place=place,
        distance=np.round(distance, DIGITS) * floor.cell_size,
        _before=before,
    )


def _walkable(state: State, unknown: Mask | None) -> Mask:
    """Free cells with enough clearance.

    Unseen ground beside an obstacle may be its other side and is kept away from like the obstacle,
    even the gaps and insides that are not worth a look.

    If the agent itself is too close to something, it may stay that close while it moves away; if it
    stands in the middle of something, it may leave.
    """
    floor, scales = state.floor, state.scales
    here = tuple(floor.cells(state.place))
    obstacles = floor.occupied | floor.touched
    for detection in state.detections:
        obstacles |= floor.disc(detection.centre, detection.radius)
    walkable = ~obstacles & _away_from(obstacles, scales.cells(scales.walk_clearance), here)
    if unknown is not None:
        clearance = scales.cells(scales.unknown_clearance)
        doubtful = unknown | floor.barred | floor.hit
        beside = near_to(floor.occupied, scales.cells(scales.hidden_reach))
        hidden = beside & (~floor.known_free | floor.hit)
        walkable &= floor.known_free & _away_from(doubtful, clearance, here)
        walkable &= _away_from(hidden, scales.cells(scales.walk_clearance), here)
    around = tuple(slice(max(0, index - 1), index + 2) for index in here)
    if obstacles[around].all():
        _open_exit(walkable, here)
    walkable[here] = True
    return walkable


def _open_exit(walkable: Mask, here: tuple[int, ...]) -> None:
    """Add the cells between a cell and the nearest walkable one to the walkable ones (X, Z)."""
    cells = np.argwhere(walkable)
    if len(cells):
        end = cells[np.hypot(*(cells - here).T).argmin()]
        between = np.linspace(here, end, 1 + 2 * int(np.abs(end - here).max()))
        walkable[tuple(np.rint(between).astype(np.intp).T)] = True


def _away_from(cells: Mask, clearance: float, here: tuple[int, ...]) -> Mask:
    """Mask (X, Z) of cells with a clearance (in cells), near `here` at most the clearance there."""
    away: Mask = ~near_to(cells, clearance)
    if away[here]:
        return away
    room = float(np.hypot(*(np.argwhere(cells) - here).T).min())
    offset = np.indices(cells.shape) - np.reshape(here, (2, 1, 1))
    close = np.hypot(*offset) <= 2.0 * clearance
    found: Mask = away | (close & ~near_to(cells, room))
    return found


@njit(cache=True)
def near_to(cells: Mask, distance: float) -> Mask:
    """Mask (X, Z) of the cells closer than a distance (in cells) to some cells (X, Z)."""
    near = np.zeros_like(cells)
    for x in range(cells.shape[0]):
        for z in range(cells.shape[1]):
            if cells[x, z] and _is_rim(cells, x, z):
                _mark(near, x, z, distance)
    return near | cells if distance > 0.0 else near


@njit(cache=True)
def _mark(near: Mask, x: int, z: int, distance: float) -> None:
    """Mark the cells (X, Z) closer than a distance (in cells) to a cell."""
    reach = math.ceil(distance)
    for i in range(max(0, x - reach), min(near.shape[0], x + reach + 1)):
        for k in range(max(0, z - reach), min(near.shape[1], z + reach + 1)):
            near[i, k] |= math.hypot(i - x, k - z) < distance


@njit(cache=True)
def _is_rim(cells: Mask, x: int, z: int) -> bool:
    """True if one of the four neighbours of a cell is not among some cells (X, Z)."""
    size_x, size_z = cells.shape
    is_lower = (x > 0 and not cells[x - 1, z]) or (z > 0 and not cells[x, z - 1])
    is_upper = (x + 1 < size_x and not cells[x + 1, z]) or (z + 1 < size_z and not cells[x, z + 1])
    return is_lower or is_upper


def unexplored(floor: Floor, obstacles: Iterable[Obstacle]) -> Mask:
    """Mask (X, Z) of unknown cells worth a look: no insides of obstacles, no small gaps."""
    unknown = unseen(floor, obstacles)
    number, _ = label(unknown, NEIGHBOURS)
    large = np.bincount(number.ravel()) >= MIN_POCKET
    large[0] = False
    return large[number]


def unseen(floor: Floor, obstacles: Iterable[Obstacle]) -> Mask:
    """Mask (X, Z) of all unknown cells except the insides of obstacles."""
    unknown = ~floor.known_free & ~floor.occupied & ~floor.touched
    for obstacle in obstacles:
        unknown[tuple(obstacle.covered.T)] = False
    return unknown
