"""Connected components of cells, by cell index or by point density."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.adjacency import neighbours
from recon.recognition.cells import distinct
from recon.recognition.unions import joined_roots, linked_roots, numbered, touching_roots

NUM_LINKS = 24
"""Neighbours a point may be linked to: the number within reach on a surface."""
FEW_LINKS = 8
"""Neighbours that suffice for points deep inside the largest component."""
SPACING_RANK = 6
"""The spacing at a point is the distance to this neighbour, in the outermost ring on a surface."""
LINK_SPACINGS = 2.0
"""Points within this number of spacings are linked."""
ON_AXIS = 0.6
"""Two parts of one object have centres closer than this share of the wider part's radius."""
SIDE_BY_SIDE = 0.5
"""Two parts that overlap by more than this share of their height are side by side."""
OVERHANG = 1.6
"""Minimum width of a crown relative to its trunk: a box on a narrower one is not its crown."""


def linked(points: NDArray[np.float64], least: float) -> NDArray[np.int32]:
    """Component label of each point; the reach of a link follows the point density.

    Parameters
    ----------
    points : (K, 3) float64
    least : float
        Points closer than this are always linked, whatever the density.

    Returns
    -------
    label : (K,) int32
        0, 1, ... in the order of the components' first points.
    """
    roots = _near_roots(points, least)
    if not roots.any():
        return roots.astype(np.int32)
    tree, count = cKDTree(points), len(points)
    distances, near = map(np.asarray, tree.query(points, k=min(FEW_LINKS, count)))
    # The denser side decides: a speck far off joins nothing, and dense points are linked already.
    reach = LINK_SPACINGS * distances[:, min(SPACING_RANK, count - 1)]
    rows = np.flatnonzero(reach > least)
    roots = linked_roots(roots, rows, distances[rows], near[rows], reach, least)
    rows = _unsettled(points, roots, reach, rows)
    if len(rows):
        distances, near = map(np.asarray, tree.query(points[rows], k=min(NUM_LINKS, count)))
        roots = linked_roots(roots, rows, distances, near, reach, least)
    label: NDArray[np.int32] = numbered(roots)
    return label


def _near_roots(points: NDArray[np.float64], least: float) -> NDArray[np.int64]:
    """Roots (K,) of points linked to those closer than `least`: often all, without a tree."""
    # Cells as wide as this hold only points that are linked, none beyond the second next cell.
    index = np.floor(points * (math.sqrt(3.0) / least)).astype(np.int64)
    cells, cell = distinct(index)
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(len(cells) + 1))
    roots: NDArray[np.int64] = touching_roots(points, order, starts, neighbours(cells, 2), least)
    return roots


def _unsettled(
    points: NDArray[np.float64],
    roots: NDArray[np.int64],
    reach: NDArray[np.float64],
    rows: NDArray[np.intp],
) -> NDArray[np.intp]:
    """Those rows that may yet be linked to another component: none deep in the largest one."""
    inside = roots == np.argmax(np.bincount(roots))
    if inside.all():
        return np.empty(0, dtype=np.intp)
    away, _ = cKDTree(points[~inside]).query(points[rows])
    return rows[away <= reach[rows]]


def joined(pairs: NDArray[np.intp], num_nodes: int) -> NDArray[np.int32]:
    """Component label of each node of a graph, in the order of the components' first nodes."""
    label: NDArray[np.int32] = numbered(joined_roots(pairs.astype(np.int64), num_nodes))
    return label


def grouped(label: NDArray[np.integer], num_groups: int) -> list[NDArray[np.intp]]:
    """Rows of each of the groups 0, 1, ... that the entries belong to, in order; -1 = none."""
    order = np.argsort(label, kind="stable")
    return np.split(order, np.searchsorted(label[order], np.arange(num_groups + 1)))[1:-1]


@njit(cache=True)
def in_order_of_appearance(label: NDArray[np.integer]) -> NDArray[np.int32]:
    """The same groups, numbered 0, 1, ... by their first member; negative labels become -1."""
    number = np.full(max(label.max(), 0) + 1 if len(label) else 0, -1)
    ordered, count = np.empty(len(label), dtype=np.int32), 0
    for i in range(len(label)):
        if label[i] >= 0 and number[label[i]] < 0:
            number[label[i]] = count
            count += 1
        ordered[i] = number[label[i]] if label[i] >= 0 else -1
    return ordered


def stacked(
    points: NDArray[np.float64], label: NDArray[np.int32], min_size: int
) -> NDArray[np.int32]:
    """Join components above each other: a wide crown hides its connection to the trunk.

    Parameters
    ----------
    points : (K, 3) float64
        World, y up.
    label : (K,) int32
        Component of each point.
    min_size : int
        Minimum size of a component that others are joined to.
    """
    low, high = _boxes(points, label)
    hosts = np.flatnonzero(np.bincount(label, minlength=len(low)) >= min_size)
    pairs = [_on_one_axis(low, high, int(host)) for host in hosts]
    return joined(np.concatenate(pairs), len(low))[label] if pairs else label


def overhanging(points: NDArray[np.float64], label: NDArray[np.int32]) -> NDArray[np.int32]:
    """Join pieces with what they overhang: a crown overhangs its trunk, a box on a box does not.

    Parameters
    ----------
    points : (K, 3) float64
        World, y up.
    label : (K,) int32
        Piece of each point.
    """
    low, high = _boxes(points, label)
    size, middle = high - low, (low + high) / 2.0
    pairs = [_on_one_axis(low, high, host) for host in range(len(low))]
    lower = np.concatenate(pairs)
    lower = np.where(middle[lower[:, :1], 1] <= middle[lower[:, 1:], 1], lower, lower[:, ::-1])
    wide = size[:, ::2].max(axis=1)
    return joined(lower[wide[lower[:, 1]] > OVERHANG * wide[lower[:, 0]]], len(low))[label]


def _boxes(
    points: NDArray[np.float64], label: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest corner (L, 3) of every component."""
    order = np.argsort(label, kind="stable")
    starts = np.searchsorted(label[order], np.arange(int(label.max(initial=-1)) + 1))
    ordered = points[order]
    return np.minimum.reduceat(ordered, starts), np.maximum.reduceat(ordered, starts)


def _on_one_axis(
    low: NDArray[np.float64], high: NDArray[np.float64], host: int
) -> NDArray[np.intp]:
    """Pairs (E, 2) of a box and the boxes above or below its centre."""
    middle, size = (low + high) / 2.0, high - low
    apart = np.hypot(*(middle - middle[host])[:, ::2].T)
    shared = np.minimum(high, high[host])[:, 1] - np.maximum(low, low[host])[:, 1]
    near = apart < ON_AXIS * size[host, ::2].max() / 2.0
    guests = np.flatnonzero(near & (shared < SIDE_BY_SIDE * size[:, 1]))
    return np.column_stack([np.full(len(guests), host), guests])
