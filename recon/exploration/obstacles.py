"""Obstacles of the map: patches of occupied floor, the views that saw them, and their names."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label
from scipy.spatial import ConvexHull

from recon.exploration.columns import Columns
from recon.exploration.floor import NEIGHBOURS, Array, Floor, Mask
from recon.recognition.connectivity import grouped
from recon.records import UNKNOWN, FoundObject, PointCloud, StereoPair, Voxels

MIN_POINTS_OF_VIEW = 30
"""A view has seen an obstacle well if it has this number of reliable points on it."""

TOP_AT = 0.5
"""Distance of the top from the middle of an obstacle, as a share of its radius."""
SURE, POSSIBLE = 0.9, 0.05
"""Minimum probability of a trusted label, and of one that is worth another look."""
MUCH_MORE = 1.1
"""Factor by which the cells of an obstacle grow in a view after which another one is worth it."""


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
    away: Array
    """(V,) distance of these positions from its disc, world units."""
    is_whole: Mask
    """(V,) True for views in which its top is not cut off."""
    found: FoundObject | None = None
    """Its name and shape, as last recognised."""
    num_named: int = 0
    """Number of its occupied cells at that time."""
    views_named: int = 0
    """Number of views that had seen it well at that time."""
    num_before: int = 0
    """Number of its occupied cells when it was named the time before."""

    @property
    def is_sure(self) -> bool:
        """True if it has a trusted label from a catalogue."""
        found = self.found
        return found is not None and found.label != UNKNOWN and (found.probability or 0.0) >= SURE

    @property
    def is_doubtful(self) -> bool:
        """True if it resembles a kind of a catalogue, but has no trusted label."""
        nearest = () if self.found is None or self.is_sure else self.found.nearest
        return bool(nearest) and nearest[0][1] >= POSSIBLE

    @property
    def is_strange(self) -> bool:
        """True if it was recognised and resembles no kind."""
        return self.found is not None and not (self.is_sure or self.is_doubtful)

    @property
    def is_growing(self) -> bool:
        """True if the last views before it was named showed much more of it."""
        return self.num_named > MUCH_MORE * self.num_before

    def holds(self, points_xz: Array, margin: float = 0.0) -> Mask:
        """Mask (N,) of the points (N, 2) within its disc, widened by a margin."""
        near: Mask = np.hypot(*(points_xz - self.centre).T) <= self.radius + margin
        return near


class UpperEdge(NamedTuple):
    """The upper edge of an image: what is higher is not in view."""

    height: float
    """Of the camera, world units."""
    slope: float
    """Rise of the edge per distance."""

    @classmethod
    def of(cls, pair: StereoPair) -> "UpperEdge":
        """The upper edge of the left image of a pair with a pose."""
        assert pair.T_world_left is not None
        ray = pair.T_world_left[:3, :3] @ [0.0, -pair.rig.cy_px / pair.rig.focal_px, 1.0]
        return cls(float(pair.T_world_left[1, 3]), float(ray[1] / np.hypot(ray[0], ray[2])))


@dataclass(slots=True, kw_only=True, eq=False)
class Observations:
    """The floor cells with reliable points, for every pair."""

    places: list[Array] = field(default_factory=list)
    """(2,) x, z of the cameras, one per pair."""
    edges: list[UpperEdge] = field(default_factory=list)
    cell: list[NDArray[np.intp]] = field(default_factory=list)
    """Flat indices of the cells with points, one array per pair."""
    number: list[NDArray[np.intp]] = field(default_factory=list)
    """Number of points on each of them."""

    def add(self, place: Array, sure: PointCloud, floor: Floor, edge: UpperEdge) -> None:
        """Record the cells of the points of another pair."""
        of_points = floor.flat(floor.cells(sure.points[:, [0, 2]]))
        cell, number = np.unique(of_points, return_counts=True)
        self.places.append(place)
        self.edges.append(edge)
        self.cell.append(cell)
        self.number.append(number)

    def seen(self, obstacle_of_cell: NDArray[np.intp], num_obstacles: int) -> NDArray[np.intp]:
        """Number (P, T) of reliable points of each pair on each obstacle.

        Parameters
        ----------
        obstacle_of_cell : (X, Z) int
            Number of the obstacle on each cell; -1 = none.
        """
        num_pairs = len(self.cell)
        if not num_pairs or not num_obstacles:
            return np.zeros((num_pairs, num_obstacles), dtype=np.intp)
        pair = np.repeat(np.arange(num_pairs), [len(cell) for cell in self.cell])
        obstacle = np.append(obstacle_of_cell.ravel(), -1)[np.concatenate(self.cell)]
        rows = np.flatnonzero(obstacle >= 0)
        both = pair[rows] * num_obstacles + obstacle[rows]
        number = np.concatenate(self.number)[rows]
        seen = np.bincount(both, number, minlength=num_pairs * num_obstacles)
        return seen.astype(np.intp).reshape(num_pairs, num_obstacles)


def patches(occupied: Mask) -> NDArray[np.intp]:
    """Patch number (X, Z) of each occupied cell, with gaps of one cell closed; -1 = none."""
    number, _ = label(binary_dilation(occupied, np.ones((2, 2), dtype=bool)), NEIGHBOURS)
    return np.where(occupied, number.astype(np.intp) - 1, -1)


def find_obstacles(
    columns: Columns,
    observations: Observations,
    min_voxels: int,
    before: Sequence[Obstacle] = (),
    touched: Mask | None = None,
) -> tuple[Obstacle, ...]:
    """Split the occupied cells above the ground into obstacles, in the order of their floor cells.

    Fewer than `min_voxels` connected cells are not an obstacle.

    Parameters
    ----------
    before : sequence of Obstacle
        Obstacles found before; those on the same floor cells, none of them touched, are kept.
    touched : (X, Z) bool, optional
        Floor cells above which the map may have changed since; all by default.
    """
    patch = patches(columns.under)
    cells_of = _cells_of(patch)
    known = {one.cells.tobytes(): one for one in before}
    old = [known.get(cells.tobytes()) for cells in cells_of]
    found = [None if one is None or _is_touched(one, touched) else one for one in old]
    new = [number for number, one in enumerate(found) if one is None]
    number = np.full(len(cells_of) + 1, -1, dtype=np.intp)
    number[new] = np.arange(len(new))
    new_of_cell = number[patch]
    voxels = columns.over(new_of_cell >= 0)
    rows_of = grouped(columns.number_of(voxels, new_of_cell), len(new))
    seen = observations.seen(new_of_cell, len(new)) >= MIN_POINTS_OF_VIEW
    places = np.array(observations.places).reshape(-1, 2)
    edges = np.array(observations.edges).reshape(-1, 2)
    for one, rows, seen_by in zip(new, rows_of, seen.T, strict=True):
        if len(rows) >= min_voxels:
            own, same = voxels.select(rows), old[one]
            covered = covered_by(cells_of[one]) if same is None else same.covered
            views = places[seen_by], edges[seen_by]
            found[one] = _obstacle(columns.floor, cells_of[one], covered, own, *views)
    return tuple(one for one in found if one is not None)


def _is_touched(obstacle: Obstacle, touched: Mask | None) -> bool:
    return touched is None or bool(touched[tuple(obstacle.cells.T)].any())


def _cells_of(patch: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """The floor cells (N, 2) of each patch (X, Z), row by row."""
    cells = np.argwhere(patch >= 0)
    number = patch[tuple(cells.T)]
    return [cells[rows] for rows in grouped(number, int(number.max(initial=-1)) + 1)]


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
    floor: Floor,
    cells: NDArray[np.intp],
    covered: NDArray[np.intp],
    voxels: Voxels,
    places: Array,
    edges: Array,
) -> Obstacle:
    """The obstacle on some cells, seen well from positions (V, 2), with upper edges (V, 2)."""
    points_xz = floor.centres(cells)
    centre = (points_xz.min(axis=0) + points_xz.max(axis=0)) / 2.0
    offsets = places - centre
    radius = float(np.hypot(*(points_xz - centre).T).max()) + 0.5 * floor.cell_size
    top = float(voxels.means[:, 1].max())
    distance = np.hypot(*offsets.T)
    highest = edges[:, 0] + edges[:, 1] * (distance - TOP_AT * radius)
    return Obstacle(
        cells=cells,
        covered=covered,
        centre=centre,
        radius=radius,
        top=top,
        voxels=voxels,
        bearings_rad=np.arctan2(offsets[:, 1], offsets[:, 0]),
        away=distance - radius,
        is_whole=highest >= top,
    )
