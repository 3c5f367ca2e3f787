"""The planes of the neighbourhoods of points, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.principal_axes import TINY, principal_axes

Array = NDArray[np.float64]

REORDERED = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order, so that several terms are added at once; NaN and infinities stay as they
are."""
WIDE = 2.0
"""Reach of the votes in a neighbourhood, over that of those of all points: at an edge the plane
settles on one of the two faces."""
NUM_ROUNDS = 3
"""Fits of a neighbourhood's plane."""
PARALLEL = 1e-12
"""Square of the sine between two rows below which these are parallel."""


@njit(cache=True)
def local_planes(
    points: Array, is_upright: bool, reach: tuple[float, float]
) -> tuple[Array, Array]:
    """The plane of each point's neighbourhood.

    Parameters
    ----------
    points : (N, 3)
    is_upright : bool
        Fit upright planes.
    reach : (float, float)
        Distances up to which points are neighbours, and vote.

    Returns
    -------
    middles, normals : (N, 3)
    """
    middles, normals = np.empty_like(points), np.empty_like(points)
    order = np.argsort(points[:, 0])
    ordered = np.ascontiguousarray(points[order].T)
    near, first = np.empty_like(ordered), 0
    for rank, i in enumerate(order):
        while ordered[0, rank] - ordered[0, first] > reach[0]:
            first += 1
        count = _copy_neighbours(ordered[:, first:], rank - first, reach[0], near)
        middle, normal = np.zeros(3), np.zeros(3)
        for _ in range(NUM_ROUNDS):
            # Without a normal all have the same vote.
            middle, moments = _spread(near, count, middle, normal / (WIDE * reach[1]))
            normal = _level_normal(moments) if is_upright else _normal(moments)
        middles[i], normals[i] = points[i] + middle, normal
    return middles, normals


@njit(cache=True)
def _copy_neighbours(ordered: Array, row: int, reach: float, near: Array) -> int:
    """Write the offsets of those within reach of one point to `near` (3, N); their number.

    Parameters
    ----------
    ordered : (3, N)
        The points by their first coordinate, without those too low for this one.
    """
    x, y, z = ordered
    count = 0
    for i in range(len(x)):
        dx, dy, dz = x[i] - x[row], y[i] - y[row], z[i] - z[row]
        if dx > reach:
            break
        near[0, count], near[1, count], near[2, count] = dx, dy, dz
        # Not an if: no branch predictor would guess it.
        count += dx * dx + dy * dy + dz * dz <= reach * reach
    return count


@njit(cache=True, fastmath=REORDERED)
def _spread(near: Array, count: int, point: Array, across: Array) -> tuple[Array, Array]:
    """Mean (3,) and moments (6,) of offsets by their votes for a plane.

    Parameters
    ----------
    across : (3,)
        Normal of the plane over the reach of the votes.
    """
    a, b, c = across[0], across[1], across[2]
    offset = a * point[0] + b * point[1] + c * point[2]
    total, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y, z = near[0, i], near[1, i], near[2, i]
        away = a * x + b * y + c * z - offset
        vote = max(1.0 - away * away, 0.0)
        total += vote
        sx, sy, sz = sx + vote * x, sy + vote * y, sz + vote * z
        xx, xy, xz = xx + vote * x * x, xy + vote * x * y, xz + vote * x * z
        yy, yz, zz = yy + vote * y * y, yz + vote * y * z, zz + vote * z * z
    share = 1.0 / max(total, TINY)
    mx, my, mz = sx * share, sy * share, sz * share
    moments = np.array(
        [xx - sx * mx, xy - sx * my, xz - sx * mz, yy - sy * my, yz - sy * mz, zz - sz * mz]
    )
    return np.array([mx, my, mz]), moments


@njit(cache=True)
def _level_normal(moments: Array) -> Array:
    """The level direction of least variance."""
    turn = 0.5 * math.atan2(2.0 * moments[2], moments[0] - moments[5]) + math.pi / 2.0
    return np.array([math.cos(turn), 0.0, math.sin(turn)])


@njit(cache=True)
def _normal(moments: Array) -> Array:
    """The direction of least variance: across the rows of the moments less their least value."""
    xx, xy, xz, yy, yz, zz = moments
    least = _least_variance(moments)
    rows = np.array([[xx - least, xy, xz], [xy, yy - least, yz], [xz, yz, zz - least]])
    normal, largest = np.zeros(3), 0.0
    for k in range(3):
        across = np.cross(rows[k], rows[(k + 1) % 3])
        square = across[0] ** 2 + across[1] ** 2 + across[2] ** 2
        if square > largest:
            normal, largest = across, square
    scale = xx + yy + zz
    if largest <= PARALLEL * scale**4:
        whole = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        normal, largest = principal_axes(whole)[1][0], 1.0
    normal /= math.sqrt(largest)
    return normal


@njit(cache=True)
def _least_variance(moments: Array) -> float:
    """The least eigenvalue of symmetric moments, by the trigonometric formula."""
    xx, xy, xz, yy, yz, zz = moments
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    square = (a * a + b * b + c * c) / 6.0 + (xy * xy + xz * xz + yz * yz) / 3.0
    spread = math.sqrt(max(square, TINY))
    a, b, c, xy, xz, yz = a / spread, b / spread, c / spread, xy / spread, xz / spread, yz / spread
    volume = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    angle = math.acos(min(max(volume / 2.0, -1.0), 1.0)) / 3.0
    least: float = mean + 2.0 * spread * math.cos(angle + 2.0 * math.pi / 3.0)
    return least
