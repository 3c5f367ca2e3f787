"""Algebra that starts fits, compiled: quantiles, moments, and lines round an axis."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.axes import across_axis

Array = NDArray[np.float64]


@njit(cache=True)
def quantiles(values: Array, shares: Array) -> Array:
    """Quantiles (S,) of values (N,) at shares (S,) between 0 and 1, linear between two values."""
    ordered = np.sort(values)
    found = np.empty(len(shares))
    for k in range(len(shares)):
        place = shares[k] * (len(values) - 1)
        low = int(place)
        high = min(low + 1, len(values) - 1)
        found[k] = ordered[low] + (place - low) * (ordered[high] - ordered[low])
    return found


@njit(cache=True)
def column_quantiles(rows: Array, shares: Array) -> Array:
    """Quantiles (S, D) of each column of rows (N, D)."""
    found = np.empty((len(shares), rows.shape[1]))
    for k in range(rows.shape[1]):
        found[:, k] = quantiles(rows[:, k].copy(), shares)
    return found


@njit(cache=True)
def spread(rows: Array) -> Array:
    """Moments (3, 3) of rows (N, 3) about their mean, over their number."""
    mean, moments = np.zeros(3), np.zeros((3, 3))
    for i in range(len(rows)):
        for j in range(3):
            mean[j] += rows[i, j] / len(rows)
    for i in range(len(rows)):
        for j in range(3):
            for k in range(3):
                moments[j, k] += (rows[i, j] - mean[j]) * (rows[i, k] - mean[k]) / len(rows)
    return moments


@njit(cache=True)
def num_parallel(normals: Array, cosine: float) -> NDArray[np.int64]:
    """Number (N,) of normals (N, 3) that are parallel to each, by the least cosine that counts."""
    counts = np.zeros(len(normals), dtype=np.int64)
    for i in range(len(normals)):
        for j in range(i + 1):
            is_parallel = abs(_dot(normals[i], normals[j])) > cosine
            counts[i] += is_parallel
            counts[j] += is_parallel and i != j
    return counts


@njit(cache=True)
def round_lines(points: Array, axes: Array, is_cone: bool) -> tuple[Array, Array]:
    """The lines round some axes (A, 3) that points (N, 3) lie near, by algebraic fits.

    Returns
    -------
    lines : (A, 8)
        A point on the axis, the axis, and offset and angle of the line in the half plane, as
        `AxialModel` has them; a cylinder's angle is 0.
    away : (A,)
        Median distance of the points to each.
    """
    lines, away = np.empty((len(axes), 8)), np.empty(len(axes))
    for k in range(len(axes)):
        lines[k, :3], lines[k, 6], lines[k, 7], away[k] = _round_line(points, axes[k], is_cone)
        lines[k, 3:6] = axes[k]
    return lines, away


@njit(cache=True)
def _round_line(points: Array, axis: Array, is_cone: bool) -> tuple[Array, float, float, float]:
    """Point, offset, angle and median distance of one of them.

    ``x^2 + y^2 = 2 a x + 2 b y + c (+ d t + e t^2)`` is linear.
    """
    across, size = across_axis(axis), 5 if is_cone else 3
    local, row = np.empty((len(points), 3)), np.ones(5)
    normal, right = np.zeros((size, size)), np.zeros(size)
    for i in range(len(points)):
        for k in range(2):
            local[i, k] = _dot(points[i], across[k])
            row[k] = 2.0 * local[i, k]
        local[i, 2] = _dot(points[i], axis)
        row[3], row[4] = local[i, 2], local[i, 2] ** 2
        for j in range(size):
            right[j] += row[j] * (local[i, 0] ** 2 + local[i, 1] ** 2)
            for k in range(size):
                normal[j, k] += row[j] * row[k]
    a, b = (np.linalg.pinv(normal) @ right)[:2]
    rho = np.hypot(local[:, 0] - a, local[:, 1] - b)
    angle = _slope(local[:, 2], rho) if is_cone else 0.0
    level = np.cos(angle) * rho - np.sin(angle) * local[:, 2]
    offset = np.median(level)
    return a * across[0] + b * across[1], offset, angle, np.median(np.abs(level - offset))


@njit(cache=True)
def _slope(t: Array, rho: Array) -> float:
    """Angle of the principal direction of points (t, rho) to the axis."""
    t, rho = t - t.mean(), rho - rho.mean()
    angle: float = np.arctan2(2.0 * (t * rho).sum(), (t * t).sum() - (rho * rho).sum()) / 2.0
    return angle


@njit(cache=True)
def _dot(first: Array, second: Array) -> float:
    product: float = first[0] * second[0] + first[1] * second[1] + first[2] * second[2]
    return product
