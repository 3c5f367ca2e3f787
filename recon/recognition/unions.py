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
