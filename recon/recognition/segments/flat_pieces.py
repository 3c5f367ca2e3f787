"""Flat pieces of an object and the remainder between them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from recon.geometry import WORLD_UP
from recon.recognition.connectivity import joined
from recon.recognition.segments.plane_votes import best_plane
from recon.records import Cylinder, Plane, Solid, Voxels

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Step = Literal["board", "upright", "any"]
"""A level board; upright planes; planes of any tilt."""

NUM_DRAWS = 300
NEIGHBOUR_CELLS = 3.5
"""Maximum distance of the cells that a plane is drawn through: some 40 are so near on a surface."""
ON_PLANE_CELLS = 0.5
"""Maximum distance of a cell on a plane."""
LINK_CELLS = 2.0
LEAST_PLANE, LEAST_SHARE = 8, 0.03
"""Minimum number of cells of a plane, and their minimum share of the object's."""
LEAST_WIDTH_CELLS = 1.8
"""Narrower strips are bars, not planes."""
LEAST_BAR = 3
MOST_PLANES = 10
FILLED = 0.5
"""Minimum share of a board's area with cells: a ring of walls has few."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatPiece:
    """A plane patch, or an upright bar."""

    rows: Rows
    """Cells of the object."""
    solid: Solid
    low: Array
    """(3,) corner of its box along the axes."""
    high: Array

    @property
    def tilt_deg(self) -> float | None:
        """Angle between a plane's normal and the vertical; None for a bar."""
        if not isinstance(self.solid, Plane):
            return None
        return float(np.degrees(np.arccos(np.clip(abs(self.solid.normal[1]), 0.0, 1.0))))


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatPieces:
    """An object taken apart into planes and bars."""

    cells: Voxels
    """Of the object."""
    planes: tuple[FlatPiece, ...]
    """By step, and of each step by descending size."""
    rest: Rows
    """Cells on none of them."""

    @cached_property
    def bars(self) -> tuple[FlatPiece, ...]:
        """Upright bars between the planes."""
        return tuple(_bars(self.cells, self.rest))


def flat_pieces(cells: Voxels, way: Sequence[Step] = ("any",)) -> FlatPieces:
    """Planes of an object, those of each step by descending size, and the bars between them.

    Parameters
    ----------
    way : sequence of str
        Planes to extract, one step after the other. Stereo errors are along the rays, which are
        nearly level, so heights are the most accurate, and the tilt of a low board the least.
    """
    rng = np.random.default_rng(0)
    rest = np.arange(len(cells))
    planes: list[FlatPiece] = []
    for step in way:
        for plane, own in _peeled(cells, rest, step, rng):
            planes.append(_piece(cells, own, plane))
            rest = np.setdiff1d(rest, own)
    return FlatPieces(cells=cells, planes=tuple(planes), rest=rest)


def _peeled(
    cells: Voxels, rest: Rows, step: Step, rng: np.random.Generator
) -> Iterator[tuple[Plane, Rows]]:
    """The planes of one step, at most `MOST_PLANES`, and their cells."""
    least = max(LEAST_PLANE, int(LEAST_SHARE * len(cells)))
    for _ in range(1 if step == "board" else MOST_PLANES):
        points = cells.means[rest]
        if len(rest) < least:
            return
        if step == "board":
            found = _board(points, cells.cell_size, least)
        else:
            found = _largest_plane(points, step, (cells.cell_size, least), rng)
        if found is None:
            return
        plane, own = found
        yield plane, rest[own]
        rest = np.delete(rest, own)


def _board(points: Array, cell_size: float, least: int) -> tuple[Plane, Rows] | None:
    """The level board with the most points and these; None if none is dense enough."""
    heights = np.sort(points[:, 1])
    reach = ON_PLANE_CELLS * cell_size
    counts = np.searchsorted(heights, heights + 2.0 * reach, side="right") - np.arange(len(points))
    middle = heights[int(np.argmax(counts))] + reach
    rows = np.flatnonzero(np.abs(points[:, 1] - middle) <= reach)
    rows = rows[_largest_group(points[rows], LINK_CELLS * cell_size)]
    if len(rows) < least or len(rows) < FILLED * _footprint(points[rows]) / cell_size**2:
        return None
    return Plane(point=points[rows].mean(axis=0), normal=np.array(WORLD_UP)), rows


def _footprint(points: Array) -> float:
    """Area that points cover when seen from above."""
    try:
        return float(ConvexHull(points[:, ::2]).volume)
    except QhullError:
        return 0.0


def _largest_plane(
    points: Array, step: Step, needs: tuple[float, int], rng: np.random.Generator
) -> tuple[Plane, Rows] | None:
    """The plane with the most connected points, and these; `needs`: cell size, minimum points."""
    firsts = rng.integers(len(points), size=NUM_DRAWS)
    shares = rng.uniform(size=(NUM_DRAWS, 2))
    reach = NEIGHBOUR_CELLS * needs[0], ON_PLANE_CELLS * needs[0]
    point, normal = best_plane(points, firsts, shares, step == "upright", reach)
    if not normal.any():
        return None
    return _refined(points, Plane(point=point, normal=normal), step, *needs)


def _refined(
    points: Array, plane: Plane, step: Step, cell_size: float, least: int
) -> tuple[Plane, Rows] | None:
    """The plane refitted to its connected points; None if they are too few or a strip."""
    best = np.flatnonzero(plane.distances(points) < ON_PLANE_CELLS * cell_size)
    if len(best) < least:
        return None
    plane = _through(points[best], step)
    best = np.flatnonzero(plane.distances(points) < ON_PLANE_CELLS * cell_size)
    if len(best) < least:
        return None
    best = best[_largest_group(points[best], LINK_CELLS * cell_size)]
    if len(best) < least or _width(points[best]) < LEAST_WIDTH_CELLS * cell_size:
        return None
    return _through(points[best], step), best


def _width(points: Array) -> float:
    """Width of a uniform strip: its standard deviation times the root of 12."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(spread[1] / np.sqrt(len(points)) * np.sqrt(12.0))


def _largest_group(points: Array, reach: float) -> NDArray[np.bool_]:
    """Mask (N,) of the largest group connected by steps up to `reach`."""
    label = joined(cKDTree(points).query_pairs(reach, output_type="ndarray"), len(points))
    largest: NDArray[np.bool_] = label == np.argmax(np.bincount(label))
    return largest


def _through(points: Array, step: Step) -> Plane:
    """The least-squares plane, with any tilt or upright."""
    middle = points.mean(axis=0)
    if step == "any":
        return Plane(point=middle, normal=_least(points - middle))
    x, z = _least((points - middle)[:, ::2])
    return Plane(point=middle, normal=np.array([x, 0.0, z]))


def _least(offsets: Array) -> Array:
    """Direction of least variation of offsets from their mean."""
    direction: Array = np.linalg.svd(offsets, full_matrices=False)[2][-1]
    return direction


def _bars(cells: Voxels, rest: Rows) -> list[FlatPiece]:
    """Upright bars in what is left, each the cells that hang together.

    Only the fuller half of the cells links: those of few points are noise between two bars, and
    belong to the nearest of them.
    """
    full = rest[cells.counts[rest] >= np.median(cells.counts[rest])] if len(rest) else rest
    if not len(full):
        return []
    tree, reach = cKDTree(cells.means[full]), LINK_CELLS * cells.cell_size
    label = joined(tree.query_pairs(reach, output_type="ndarray"), len(full))
    _, nearest = tree.query(cells.means[rest], distance_upper_bound=reach)
    label = np.append(label, np.int32(-1))[nearest]
    order = np.argsort(label, kind="stable")
    borders = np.searchsorted(label[order], np.arange(int(label.max()) + 2))
    groups = [rest[order[low:high]] for low, high in pairwise(borders) if high - low >= LEAST_BAR]
    return [_piece(cells, rows, _bar(cells.means[rows])) for rows in groups]


def _bar(points: Array) -> Cylinder:
    middle = points.mean(axis=0)
    radius = float(np.median(np.hypot(*(points - middle)[:, ::2].T)))
    low, high = points[:, 1].min(), points[:, 1].max()
    return Cylinder(
        point=np.array([middle[0], low, middle[2]]),
        axis=np.array(WORLD_UP),
        radius=radius,
        height=float(high - low),
    )


def _piece(cells: Voxels, rows: Rows, solid: Solid) -> FlatPiece:
    points = cells.means[rows]
    return FlatPiece(rows=rows, solid=solid, low=points.min(axis=0), high=points.max(axis=0))
