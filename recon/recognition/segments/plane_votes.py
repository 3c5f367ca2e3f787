"""The plane through drawn points that most points vote for, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

LEAST_SPAN = 1e-9
"""Minimum area of a triangle over the square of the points' extent: three points on a line span no
plane."""


@njit(cache=True)
def best_plane(
    points: Array, firsts: Numbers, shares: Array, is_upright: bool, reach: tuple[float, float]
) -> tuple[Array, Array]:
    """The plane through three neighbouring points that has the most votes.

    Closer points count more: a plane across an edge is near many points but close to few.

    Parameters
    ----------
    points : (N, 3)
    firsts : (D,)
        One point per draw.
    shares : (D, 2)
        Random numbers in [0, 1) that choose two of its neighbours.
    is_upright : bool
        Turn the planes upright.
    reach : (float, float)
        Distances up to which points are neighbours, and vote.

    Returns
    -------
    point, normal : (3,)
        The normal is 0 if no draw spans a plane.
    """
    extent = 0.0
    for axis in range(3):
        extent = max(extent, points[:, axis].max() - points[:, axis].min())
    best, point, normal = -1.0, np.zeros(3), np.zeros(3)
    near = np.empty(len(points), dtype=np.int64)
    for d in range(len(firsts)):
        first, count = points[firsts[d]], _neighbours(points, firsts[d], reach[0], near)
        second = points[near[int(shares[d, 0] * count)]]
        third = points[near[int(shares[d, 1] * count)]]
        across = _across(second - first, third - first, is_upright)
        length = math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
        if length > LEAST_SPAN * extent**2:
            across /= length
            total = _votes(points, first, across, reach[1])
            if total > best:
                best, point, normal = total, first, across
    return point, normal


@njit(cache=True)
def _neighbours(points: Array, first: int, reach: float, near: Numbers) -> int:
    """Write the rows of the points within reach of one of them; their number."""
    count, x, y, z = 0, points[first, 0], points[first, 1], points[first, 2]
    for i in range(len(points)):
        square = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        if square <= reach * reach:
            near[count] = i
            count += 1
    return count


@njit(cache=True)
def _across(first: Array, second: Array, is_upright: bool) -> Array:
    """Cross product (3,) of two directions, without its vertical part if upright."""
    across = np.empty(3)
    across[0] = first[1] * second[2] - first[2] * second[1]
    across[1] = 0.0 if is_upright else first[2] * second[0] - first[0] * second[2]
    across[2] = first[0] * second[1] - first[1] * second[0]
    return across


@njit(cache=True)
def _votes(points: Array, point: Array, normal: Array, reach: float) -> float:
    """Sum of the votes of all points for a plane."""
    total = 0.0
    offset = point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]
    for i in range(len(points)):
        along = points[i, 0] * normal[0] + points[i, 1] * normal[1] + points[i, 2] * normal[2]
        total += max(1.0 - ((along - offset) / reach) ** 2, 0.0)
    return total
