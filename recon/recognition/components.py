"""Which cells belong together: connected components with a gap."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

ON_AXIS = 0.6
"""Middles of two parts of one object are nearer than this share of the wider one's reach."""


def connected(index: NDArray[np.int64], reach: int = 1) -> NDArray[np.int32]:
    """Number of the component of each cell.

    Parameters
    ----------
    index : (K, 3) int
        Cell numbers.
    reach : int
        Cells are neighbours that lie at most so many apart along every axis: 1 = the 26
        neighbours, 2 closes gaps of one cell.

    Returns
    -------
    label : (K,) int32
        0, 1, ... in the order of each component's first cell.
    """
    return joined(neighbours(index, reach), len(index))


def neighbours(index: NDArray[np.int64], reach: int = 1) -> NDArray[np.intp]:
    """Pairs (E, 2) of rows whose cells lie at most `reach` apart along every axis."""
    if len(index) < 2:
        return np.empty((0, 2), dtype=np.intp)
    return cKDTree(index).query_pairs(reach + 0.5, p=np.inf, output_type="ndarray")


def joined(pairs: NDArray[np.intp], num_nodes: int) -> NDArray[np.int32]:
    """Number of the component of each node of a graph, in the order of their first nodes."""
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(num_nodes, num_nodes))
    _, label = connected_components(graph, directed=False)
    return in_order_of_appearance(label)


def in_order_of_appearance(label: NDArray[np.integer]) -> NDArray[np.int32]:
    """The same groups, numbered 0, 1, ... by their first member; negative labels stay -1."""
    kept = label >= 0
    _, first, inverse = np.unique(label[kept], return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    ordered = np.full(len(label), -1, dtype=np.int32)
    ordered[kept] = rank[inverse]
    return ordered


def stacked(
    points: NDArray[np.float64], label: NDArray[np.int32], min_size: int
) -> NDArray[np.int32]:
    """Components that stand over each other joined: a wide crown hides how its trunk reaches it.

    Parameters
    ----------
    points : (K, 3) float64
        World, y up.
    label : (K,) int32
        Component of each point.
    min_size : int
        Smallest component that others are joined to.
    """
    count = int(label.max(initial=-1)) + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, label, points[:, ::2])
    np.maximum.at(high, label, points[:, ::2])
    middle, reach = (low + high) / 2.0, (high - low).max(axis=1) / 2.0
    hosts = np.flatnonzero(np.bincount(label, minlength=count) >= min_size)
    pairs = [
        np.column_stack([np.full(len(guests), host), guests])
        for host in hosts
        for guests in [_within(middle, middle[host], ON_AXIS * reach[host])]
    ]
    if not pairs:
        return label
    return joined(np.concatenate(pairs), count)[label]


def _within(
    places: NDArray[np.float64], centre: NDArray[np.float64], reach: float
) -> NDArray[np.intp]:
    return np.flatnonzero(np.hypot(*(places - centre).T) < reach)
