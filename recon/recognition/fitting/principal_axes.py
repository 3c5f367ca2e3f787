"""Principal axes of points, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_SWEEPS = 20
"""Jacobi sweeps; they converge quadratically, so that 6 are usual."""
TINY = 1e-300
"""Least total weight, so that points without weight give no division by 0."""


@njit(cache=True)
def principal_axes(moments: Array) -> tuple[Array, Array]:
    """Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi rotations.

    Parameters
    ----------
    moments : (3, 3) float64
        Covariance of points, or any multiple of it.

    Returns
    -------
    values : (3,) ascending
    axes : (3, 3)
        Unit eigenvectors, one per row.
    """
    a, v = moments.copy(), np.eye(3)
    for _ in range(MOST_SWEEPS):
        off = abs(a[0, 1]) + abs(a[0, 2]) + abs(a[1, 2])
        if off <= 1e-16 * (abs(a[0, 0]) + abs(a[1, 1]) + abs(a[2, 2])):
            break
        _rotate(a, v, 0, 1)
        _rotate(a, v, 0, 2)
        _rotate(a, v, 1, 2)
    values, axes = np.empty(3), np.empty((3, 3))
    for k in range(3):
        # The rank of the kth value; the earlier of two equal ones comes first.
        rank = 0
        for j in range(3):
            rank += a[j, j] < a[k, k] or (a[j, j] == a[k, k] and j < k)
        values[rank], axes[rank] = a[k, k], v[:, k]
    return values, axes


@njit(cache=True)
def _rotate(a: Array, v: Array, p: int, q: int) -> None:
    """Turn a symmetric matrix (3, 3), and the axes, so that its entry (p, q) is 0."""
    if a[p, q] == 0.0:
        return
    theta = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
    t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
    c = 1.0 / math.sqrt(t * t + 1.0)
    s = t * c
    for k in range(3):
        a[k, p], a[k, q] = c * a[k, p] - s * a[k, q], s * a[k, p] + c * a[k, q]
    for k in range(3):
        a[p, k], a[q, k] = c * a[p, k] - s * a[q, k], s * a[p, k] + c * a[q, k]
    for k in range(3):
        v[k, p], v[k, q] = c * v[k, p] - s * v[k, q], s * v[k, p] + c * v[k, q]


@njit(cache=True)
def weighted_spread(points: Array, weights: Array) -> tuple[Array, Array]:
    """Weighted mean (3,) of points (N, 3), and their weighted moments (3, 3) about it."""
    mean, total = np.zeros(3), 0.0
    for i in range(len(points)):
        total += weights[i]
        for j in range(3):
            mean[j] += weights[i] * points[i, j]
    mean /= max(total, TINY)
    moments = np.zeros((3, 3))
    for i in range(len(points)):
        for j in range(3):
            along = weights[i] * (points[i, j] - mean[j])
            for k in range(3):
                moments[j, k] += along * (points[i, k] - mean[k])
    return mean, moments
