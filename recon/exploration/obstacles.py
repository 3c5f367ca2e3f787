"""Obstacles of the map: patches of occupied floor, the views that saw them, and their names."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label
from scipy.spatial import ConvexHull

from recon.exploration.floor import NEIGHBOURS, Array, Floor, Mask
from recon.records import UNKNOWN, FoundObject, PointCloud, Voxels

MIN_POINTS_OF_VIEW = 30
"""A view has seen an obstacle well if it has this number of reliable points on it."""

SURE = 0.9
"""Minimum probability of a trusted label."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Obstacle:
    """One obstacle of the map."""

    cells: NDArray[np.intp]
    """(N, 2) floor cells under it."""
    covered: NDArray[np.intp]
    """(M, 2) floor cells whose centre is in the convex hull of those."""
    centre: Array
    """(2,) x, z of the centre of its box."""
    radius: float
    """Radius of the disc around `centre` that contains it, world units."""
    top: float
    """Height of its highest cell, world units."""
    voxels: Voxels
    """Its occupied cells above the ground."""
    bearings_rad: Array
    """(V,) azimuth, from the obstacle, of every position that saw it well."""
    found: FoundObject | None = None
    """Its name and shape, as last recognised."""
    num_named: int = 0
    """Number of its occupied cells at that time."""

    @property
    def is_sure(self) -> bool:
        """True if it has a trusted label from a catalogue."""
        found = self.found
        return found is not None and found.label != UNKNOWN and (found.probability or 0.0) >= SURE

    def holds(self, points_xz: Array, margin: float = 0.0) -> Mask:
        """Mask (N,) of the points (N, 2) within its disc, widened by a margin."""
        near: Mask = np.hypot(*(points_xz - self.centre).T) <= self.radius + margin
        return near


@dataclass(slots=True, kw_only=True, eq=False)
class Observations:
    """The floor cells with reliable points, for every pair."""

    places: list[Array] = field(default_factory=list)
    """(2,) x, z of the cameras, one per pair."""
    cell: list[NDArray[np.intp]] = field(default_factory=list)
    """Flat indices of cells, one array per pair, one entry per point."""

    def add(self, place: Array, sure: PointCloud, floor: Floor) -> None:
        """Record the cells of the points of another pair."""
        self.places.append(place)
        self.cell.append(floor.flat(floor.cells(sure.points[:, [0, 2]])))

    def seen(self, obstacle_of_cell: NDArray[np.intp], num_obstacles: int) -> NDArray[np.intp]:
        """Number (P, T) of reliable points of each pair on each obstacle.

        Parameters
        ----------
        obstacle_of_cell : (X, Z) int
            Number of the obstacle on each cell; -1 = none.
        """
        num_pairs = len(self.cell)
        if not num_pairs:
            return np.zeros((0, num_obstacles), dtype=np.intp)
        pair = np.repeat(np.arange(num_pairs), [len(cell) for cell in self.cell])
        obstacle = np.append(obstacle_of_cell.ravel(), -1)[np.concatenate(self.cell)]
        both = (pair * num_obstacles + obstacle)[obstacle >= 0]
        seen = np.bincount(both, minlength=num_pairs * num_obstacles)
        return seen.reshape(num_pairs, num_obstacles)


def columns(voxels: Voxels, spacing: float) -> Array:
    """Points (N, 2) x, z, at most `spacing` apart, that cover the cells in top view."""
    number = max(1, int(np.ceil(voxels.cell_size / spacing)))
    steps = ((np.arange(number) + 0.5) / number - 0.5) * voxels.cell_size
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    points: Array = (voxels.centres[:, None, [0, 2]] + offsets).reshape(-1, 2)
    return points


def patches(occupied: Mask) -> NDArray[np.intp]:
    """Patch number (X, Z) of each occupied cell, with gaps of one cell closed; -1 = none."""
    number, _ = label(binary_dilation(occupied, np.ones((2, 2), dtype=bool)), NEIGHBOURS)
    return np.where(occupied, number.astype(np.intp) - 1, -1)


def find_obstacles(
    voxels: Voxels,
    floor: Floor,
    observations: Observations,
    min_voxels: int,
    before: Sequence[Obstacle] = (),
) -> tuple[Obstacle, ...]:
    """Split the occupied cells above the ground into obstacles, in the order of their floor cells.

    Fewer than `min_voxels` connected cells are not an obstacle. Obstacles that have not changed
    since `before` are kept.
    """
    patch = patches(floor.mask(columns(voxels, floor.cell_size)))
    of_voxel = np.append(patch.ravel(), -1)[floor.flat(floor.cells(voxels.centres[:, [0, 2]]))]
    size = np.bincount(of_voxel[of_voxel >= 0], minlength=patch.max(initial=-1) + 1)
    number = np.append(np.where(size >= min_voxels, np.cumsum(size >= min_voxels) - 1, -1), -1)
    obstacle_of_cell, obstacle_of_voxel = number[patch], number[of_voxel]
    num_obstacles = int(number.max(initial=-1)) + 1
    seen = observations.seen(obstacle_of_cell, num_obstacles) >= MIN_POINTS_OF_VIEW
    known = {one.cells.tobytes(): one for one in before}
    places = np.array(observations.places).reshape(-1, 2)
    cells = np.column_stack(np.unravel_index(np.arange(obstacle_of_cell.size), floor.shape))
    found = []
    for cells_of, voxels_of, seen_by in zip(
        _groups(obstacle_of_cell.ravel(), num_obstacles),
        _groups(obstacle_of_voxel, num_obstacles),
        seen.T,
        strict=True,
    ):
        own = cells[cells_of]
        old = known.get(own.tobytes())
        if old is None or not _are_of(old, voxels, voxels_of):
            old = _obstacle(floor, own, voxels.select(voxels_of), old)
        offsets = places[seen_by] - old.centre
        found.append(replace(old, bearings_rad=np.arctan2(offsets[:, 1], offsets[:, 0])))
    return tuple(found)


def _are_of(obstacle: Obstacle, voxels: Voxels, rows: NDArray[np.intp]) -> bool:
    """Tell whether some voxels are those of an obstacle, without a new point in them."""
    own = obstacle.voxels
    is_same = np.array_equal(own.index, voxels.index[rows])
    return is_same and np.array_equal(own.counts, voxels.counts[rows])


def _groups(number: NDArray[np.intp], num_groups: int) -> list[NDArray[np.intp]]:
    """Rows of each group, in order; rows with number -1 are in none."""
    order = np.argsort(number, kind="stable")
    return np.split(order, np.searchsorted(number[order], np.arange(num_groups + 1)))[1:-1]


def covered_by(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Cells (M, 2) whose centre is in the convex hull of some cells (N, 2)."""
    square = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
    hull = ConvexHull((cells[:, None] + square).reshape(-1, 2))
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    box = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1)
    signed = (box + 0.5) @ hull.equations[:, :2].T + hull.equations[:, 2]
    covered: NDArray[np.intp] = box[(signed <= 1e-9).all(axis=-1)]
    return covered


def _obstacle(
    floor: Floor, cells: NDArray[np.intp], voxels: Voxels, old: Obstacle | None
) -> Obstacle:
    """The obstacle on some cells, which may be those of an old one."""
    points_xz = floor.centres(cells)
    centre = (points_xz.min(axis=0) + points_xz.max(axis=0)) / 2.0
    return Obstacle(
        cells=cells,
        covered=covered_by(cells) if old is None else old.covered,
        centre=centre,
        radius=float(np.hypot(*(points_xz - centre).T).max()) + 0.5 * floor.cell_size,
        top=float(voxels.means[:, 1].max()),
        voxels=voxels,
        bearings_rad=np.empty(0),
    )
