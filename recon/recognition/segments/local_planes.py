"""The planes of the neighbourhoods of points, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.adjacency import ordered_pairs
from recon.recognition.fitting.least_axis import Moments, Vector, least_axis
from recon.recognition.fitting.principal_axes import TINY

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

REORDERED = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order, so that several terms are added at once; NaN and infinities stay as they
are."""
WIDE = 2.0
"""Reach of the votes in a neighbourhood, over that of those of all points: at an edge the plane
settles on one of the two faces."""
NUM_ROUNDS = 3
"""Fits of a neighbourhood's plane."""


@njit(cache=True)
def surroundings(points: Array, reach: float) -> tuple[Numbers, Numbers]:
    """The points within reach of each of some, itself among them.

    Parameters
    ----------
    points : (N, 3)

    Returns
    -------
    starts : (N + 1,)
        Where those of each point start in `near`.
    near : (M,)
        Rows of points, those of one point by their first coordinate.
    """
    order = np.argsort(points[:, 0])
    pairs, count = ordered_pairs(np.ascontiguousarray(points[order].T), reach)
    starts = np.zeros(len(points) + 1, dtype=np.int64)
    starts[1:] = 1
    for k in range(count):
        starts[order[pairs[0, k]] + 1] += 1
        starts[order[pairs[1, k]] + 1] += 1
    starts = np.cumsum(starts)
    near, ends, k = np.empty(starts[-1], dtype=np.int64), starts[:-1].copy(), 0
    for rank, row in enumerate(order):
        near[ends[row]] = row
        ends[row] += 1
        while k < count and pairs[0, k] == rank:
            other = order[pairs[1, k]]
            near[ends[row]], near[ends[other]] = other, row
            ends[row] += 1
            ends[other] += 1
            k += 1
    return starts, near


@njit(cache=True)
def local_planes(
    points: Array, around: tuple[Numbers, Numbers], rows: Numbers, is_upright: bool, reach: float
) -> tuple[Array, Array]:
    """The planes of the neighbourhoods of some points, among these.

    Parameters
    ----------
    points : (N, 3)
    around : tuple
        The `surroundings` of all of them.
    rows : (R,)
        Those that count.
    is_upright : bool
        Fit upright planes.
    reach : float
        Distance up to which points vote.

    Returns
    -------
    middles, normals : (R, 3)
    """
    middles, normals = np.empty((len(rows), 3)), np.empty((len(rows), 3))
    offsets, counts = np.empty((3, len(points))), np.zeros(len(points), dtype=np.int64)
    counts[rows] = 1
    for k, row in enumerate(rows):
        near = offsets[:, : _write_offsets(points, row, around, counts, offsets)]
        middle, normal = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for _ in range(NUM_ROUNDS):
            # Without a normal all have the same vote.
            middle, moments = _spread(near, middle, normal, 1.0 / (WIDE * reach))
            normal = _level_normal(moments) if is_upright else least_axis(moments)
        for axis in range(3):
            middles[k, axis] = points[row, axis] + middle[axis]
            normals[k, axis] = normal[axis]
    return middles, normals


@njit(cache=True)
def _write_offsets(
    points: Array, row: int, around: tuple[Numbers, Numbers], counts: Numbers, offsets: Array
) -> int:
    """Write the offsets (3, N) of those around one point that count, each 1; their number."""
    (starts, near), count = around, 0
    for place in range(starts[row], starts[row + 1]):
        other = near[place]
        for axis in range(3):
            offsets[axis, count] = points[other, axis] - points[row, axis]
        count += counts[other]
    return count


@njit(cache=True, fastmath=REORDERED)
def _spread(near: Array, point: Vector, normal: Vector, scale: float) -> tuple[Vector, Moments]:
    """Mean and moments of offsets (3, N) by their votes for a plane.

    Parameters
    ----------
    scale : float
        One over the reach of the votes.
    """
    a, b, c = normal[0] * scale, normal[1] * scale, normal[2] * scale
    offset = a * point[0] + b * point[1] + c * point[2]
    total, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(near.shape[1]):
        x, y, z = near[0, i], near[1, i], near[2, i]
        away = a * x + b * y + c * z - offset
        vote = max(1.0 - away * away, 0.0)
        total += vote
        sx, sy, sz = sx + vote * x, sy + vote * y, sz + vote * z
        xx, xy, xz = xx + vote * x * x, xy + vote * x * y, xz + vote * x * z
        yy, yz, zz = yy + vote * y * y, yz + vote * y * z, zz + vote * z * z
    share = 1.0 / max(total, TINY)
    mx, my, mz = sx * share, sy * share, sz * share
    moments = xx - sx * mx, xy - sx * my, xz - sx * mz, yy - sy * my, yz - sy * mz, zz - sz * mz
    return (mx, my, mz), moments


@njit(cache=True)
def _level_normal(moments: Moments) -> Vector:
    """The level direction of least variance."""
    turn = 0.5 * math.atan2(2.0 * moments[2], moments[0] - moments[5]) + math.pi / 2.0
    return math.cos(turn), 0.0, math.sin(turn)
