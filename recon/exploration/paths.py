"""Shortest paths over the floor that keep away from obstacles and unknown ground."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

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
        steps = [*self._cells_to(end_xz), end_xz]
        corners: list[Array] = []
        anchor = self.place
        for here, ahead in itertools.pairwise(steps):
            if not self.is_clear(anchor, ahead):
                corners.append(here)
                anchor = here
        return np.array(corners).reshape(-1, 2)

    def _cells_to(self, end_xz: Array) -> list[Array]:
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

    If the agent itself is too close to something, it may stay that close while it moves away.
    """
    floor, scales = state.floor, state.scales
    here = tuple(floor.cells(state.place))
    obstacles = floor.occupied | floor.touched
    for detection in state.detections:
        obstacles |= floor.disc(detection.centre, detection.radius)
    walkable = ~obstacles & _away_from(obstacles, scales.cells(scales.walk_clearance), here)
    if unknown is not None:
        clearance = scales.cells(scales.unknown_clearance)
        walkable &= floor.known_free & _away_from(unknown | floor.barred, clearance, here)
    walkable[here] = True
    return walkable


def _away_from(cells: Mask, clearance: float, here: tuple[int, ...]) -> Mask:
    """Mask (X, Z) of cells with a clearance (in cells), near `here` at most the clearance there."""
    if not cells.any():
        return np.ones_like(cells)
    room: Array = distance_transform_edt(~cells)
    if room[here] >= clearance:
        return room >= clearance
    offset = np.indices(cells.shape) - np.reshape(here, (2, 1, 1))
    close = np.hypot(*offset) <= 2.0 * clearance
    away: Mask = room >= np.where(close, min(clearance, float(room[here])), clearance)
    return away


def unexplored(floor: Floor, obstacles: Iterable[Obstacle]) -> Mask:
    """Mask (X, Z) of unknown cells worth a look: no insides of obstacles, no small gaps."""
    unknown = ~floor.known_free & ~floor.occupied & ~floor.touched
    for obstacle in obstacles:
        unknown[tuple(obstacle.covered.T)] = False
    number, _ = label(unknown, NEIGHBOURS)
    large = np.bincount(number.ravel()) >= MIN_POCKET
    large[0] = False
    return large[number]
