"""Disjoint sets, compiled: joined nodes share one root, the first of them (Tarjan 1975)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@njit(cache=True)
def joined_roots(pairs: Numbers, num_nodes: int) -> Numbers:
    """Root (N,) of each node after joining the pairs (E, 2)."""
    parent = np.arange(num_nodes)
    for e in range(len(pairs)):
        _join(parent, pairs[e, 0], pairs[e, 1])
    _settle(parent)
    return parent


@njit(cache=True)
def touching_roots(
    points: Array, order: Numbers, starts: Numbers, pairs: Numbers, reach: float
) -> Numbers:
    """Root (N,) of each point after those of one cell, and those within reach, were joined.

    Parameters
    ----------
    points : (N, 3)
    order : (N,) their rows, cell by cell
    starts : (C + 1,) where the rows of each cell start
    pairs : (E, 2)
        Neighbouring cells; only between these there are links.
    reach : float
        At least the diagonal of a cell.
    """
    parent = np.arange(len(points))
    for cell in range(len(starts) - 1):
        for k in range(starts[cell] + 1, starts[cell + 1]):
            _join(parent, order[starts[cell]], order[k])
    for first, second in pairs:
        own = order[starts[first] : starts[first + 1]]
        others = order[starts[second] : starts[second + 1]]
        # All of a cell have one root.
        if _root(parent, own[0]) != _root(parent, others[0]) and _touch(points, own, others, reach):
            _join(parent, own[0], others[0])
    _settle(parent)
    return parent


@njit(cache=True)
def _touch(points: Array, first: Numbers, second: Numbers, reach: float) -> bool:
    """True if two groups of points have some within reach of each other."""
    for i in first:
        for j in second:
            square = 0.0
            for axis in range(3):
                square += (points[i, axis] - points[j, axis]) ** 2
            if square <= reach * reach:
                return True
    return False


@njit(cache=True)
def linked_roots(
    roots: Numbers, rows: Numbers, distances: Array, near: Numbers, reach: Array, least: float
) -> Numbers:
    """Root (N,) of each point after some were joined with those of their neighbours within reach.

    Parameters
    ----------
    roots : (N,)
        Of each point so far.
    rows : (M,)
        Points whose neighbours are known.
    distances, near : (M, K)
        Of each of these to its neighbours, and the neighbours.
    reach : (N,)
        Reach of each point; the smaller of two counts, but at least `least`.
    """
    parent = roots.copy()
    for m in range(len(rows)):
        i = rows[m]
        for k in range(near.shape[1]):
            j = near[m, k]
            if distances[m, k] <= max(min(reach[i], reach[j]), least):
                _join(parent, i, j)
    _settle(parent)
    return parent


@njit(cache=True)
def agreed_roots(
    pairs: Numbers, is_for: NDArray[np.bool_], num_nodes: int, least: float
) -> Numbers:
    """Root (N,) of each node after joining groups between which enough pairs are for it.

    Parameters
    ----------
    pairs : (E, 2)
        Those that may join first come first.
    is_for : (E,)
        Which pairs are for joining their groups; the others are against it.
    least : float
        Minimum share of the pairs between two groups that are for it.
    """
    roots = np.arange(num_nodes)
    votes = np.zeros((2, num_nodes, num_nodes), dtype=np.int32)
    for e in range(len(pairs)):
        for first, second in ((pairs[e, 0], pairs[e, 1]), (pairs[e, 1], pairs[e, 0])):
            votes[0, first, second] += is_for[e]
            votes[1, first, second] += 1
    is_joining = True
    while is_joining:
        is_joining = False
        for edge in np.flatnonzero(is_for):
            i, j = sorted((roots[pairs[edge, 0]], roots[pairs[edge, 1]]))
            if i != j and votes[0, i, j] > least * votes[1, i, j]:
                roots[roots == j] = i
                votes[:, i] += votes[:, j]
                votes[:, :, i] = votes[:, i]
                is_joining = True
    return roots


@njit(cache=True)
def numbered(roots: Numbers) -> NDArray[np.int32]:
    """Group numbers (N,) 0, 1, ... in the order of their first members, which are their roots."""
    label = np.empty(len(roots), dtype=np.int32)
    count = 0
    for i in range(len(roots)):
        if roots[i] == i:
            label[i] = count
            count += 1
        else:
            label[i] = label[roots[i]]
    return label


@njit(cache=True)
def _join(parent: Numbers, first: int, second: int) -> None:
    a, b = _root(parent, first), _root(parent, second)
    if a < b:
        parent[b] = a
    elif b < a:
        parent[a] = b


@njit(cache=True)
def _root(parent: Numbers, node: int) -> int:
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


@njit(cache=True)
def _settle(parent: Numbers) -> None:
    """Give every node its root; parents come before their children."""
    for i in range(len(parent)):
        parent[i] = parent[parent[i]]
