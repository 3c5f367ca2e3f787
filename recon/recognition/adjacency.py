"""Pairs of neighbouring cells and points, compiled: sorted by place, neighbours are a run."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.cells import LARGEST_KEY

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

MOST_AT_FIRST = 32
"""Pairs of neighbours a point for which there is room from the start: some 20 are usual."""


def neighbours(index: Numbers, reach: int = 1) -> NDArray[np.intp]:
    """Pairs (E, 2) of rows whose cells are at most `reach` apart along every axis."""
    if len(index) < 2:
        return np.empty((0, 2), dtype=np.intp)
    low, high = index.min(axis=0), index.max(axis=0)
    x_span, y_span, z_span = (high - low + 1 + 2 * reach).tolist()
    if math.prod((x_span, y_span, z_span)) > LARGEST_KEY:
        return cKDTree(index).query_pairs(reach + 0.5, p=np.inf, output_type="ndarray")
    x, y, z = (index - low).T
    keys = (x * y_span + y) * z_span + z
    order = np.argsort(keys, kind="stable")
    sides = range(-reach, reach + 1)
    rows = [x * y_span + y for x in sides for y in sides]
    # Each pair once: of the rows of cells those after the own one, and what follows in that.
    later = np.array([row * z_span for row in rows if row > 0])
    runs = np.array([(1, reach), *np.column_stack([later - reach, later + reach])])
    pairs: NDArray[np.intp] = _pairs(keys[order], order, runs)
    return pairs


@njit(cache=True)
def _pairs(keys: Numbers, order: Numbers, runs: Numbers) -> Numbers:
    """Pairs (E, 2) of cells whose keys differ by a number in one of some runs.

    Parameters
    ----------
    keys : (K,) ascending
    order : (K,) the row of each
    runs : (R, 2) first and last difference
    """
    most = len(keys) * (runs[:, 1] - runs[:, 0] + 1).sum()
    pairs, count = np.empty((most, 2), dtype=np.int64), 0
    for low, high in runs:
        first = 0
        for k in range(len(keys)):
            while first < len(keys) and keys[first] < keys[k] + low:
                first += 1
            other = first
            while other < len(keys) and keys[other] <= keys[k] + high:
                pairs[count, 0], pairs[count, 1] = order[k], order[other]
                count += 1
                other += 1
    return pairs[:count].copy()


def near_pairs(points: Array, reach: float) -> Numbers:
    """Pairs (2, M) of rows of points (N, 3) at most `reach` apart."""
    # Along the longest side of their box the fewest are within reach of each other.
    axes = np.argsort(-np.ptp(points, axis=0))
    order = np.argsort(points[:, axes[0]])
    pairs, count = ordered_pairs(np.ascontiguousarray(points[order].T[axes]), reach)
    rows: Numbers = order[pairs[:, :count]]
    return rows


@njit(cache=True)
def ordered_pairs(ordered: Array, reach: float) -> tuple[Numbers, int]:
    """Pairs (2, M) of points (3, N), given by their first coordinate, and how many count."""
    x, y, z = ordered
    pairs, count = np.empty((2, MOST_AT_FIRST * len(x)), dtype=np.int64), 0
    for i in range(len(x)):
        if count + len(x) > pairs.shape[1]:
            pairs = np.concatenate((pairs, np.empty_like(pairs)), axis=1)
        for j in range(i + 1, len(x)):
            dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
            if dx > reach:
                break
            pairs[0, count], pairs[1, count] = i, j
            # Not an if: no branch predictor would guess it.
            count += dx * dx + dy * dy + dz * dz <= reach * reach
    return pairs, count
