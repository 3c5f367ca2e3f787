"""The plane that most points vote for, among those of the neighbourhoods of all points, compiled.

No plane is drawn at random, so that the one found changes little where the points change little.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.principal_axes import principal_axes, weighted_spread

Array = NDArray[np.float64]

WIDE = 2.0
"""Reach of the votes in a neighbourhood, over that of those of all points: at an edge the plane
settles on one of the two faces."""
LOCAL_ROUNDS, MOST_ROUNDS = 3, 10
"""Fits of a neighbourhood's plane, and the most of the best plane to all points."""


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
    for i in range(len(points)):
        near = _neighbours(points, i, reach[0])
        middle, normal = fitted_plane(near, np.ones(len(near)), is_upright)
        for _ in range(LOCAL_ROUNDS - 1):
            votes = votes_for(near, middle, normal, WIDE * reach[1])
            middle, normal = fitted_plane(near, votes, is_upright)
        middles[i], normals[i] = middle, normal
    return middles, normals


@njit(cache=True)
def best_plane(
    points: Array, middles: Array, normals: Array, is_upright: bool, reach: float
) -> tuple[Array, Array]:
    """The plane with the most votes, fitted to the points that vote for it.

    Closer points count more: a plane across an edge is near many points but close to few.

    Parameters
    ----------
    points : (N, 3)
    middles, normals : (P, 3)
        The planes to choose from, upright if these are asked for.
    is_upright : bool
        Keep the plane upright.
    reach : float
        Distance up to which points vote.

    Returns
    -------
    point, normal : (3,)
    """
    best, point, normal = -1.0, np.zeros(3), np.zeros(3)
    for i in range(len(middles)):
        total = sum_of_votes(points, middles[i], normals[i], reach)
        if total > best:
            best, point, normal = total, middles[i], normals[i]
    for _ in range(MOST_ROUNDS):
        middle, across = fitted_plane(points, votes_for(points, point, normal, reach), is_upright)
        total = sum_of_votes(points, middle, across, reach)
        if total <= best:
            break
        best, point, normal = total, middle, across
    return point, normal


@njit(cache=True)
def fitted_plane(points: Array, weights: Array, is_upright: bool) -> tuple[Array, Array]:
    """Weighted mean of points, and the direction in which they vary least, level if upright."""
    middle, moments = weighted_spread(points, weights)
    if is_upright:
        moments[0, 1] = moments[1, 0] = moments[1, 2] = moments[2, 1] = 0.0
        moments[1, 1] = 1.0 + moments[0, 0] + moments[2, 2]
    return middle, principal_axes(moments)[1][0]


@njit(cache=True)
def largest_group(points: Array, reach: float) -> NDArray[np.bool_]:
    """Mask (N,) of the largest group connected by steps up to `reach`, the first of several."""
    group = np.full(len(points), -1)
    waiting = np.empty(len(points), dtype=np.int64)
    most, largest = 0, 0
    for first in range(len(points)):
        if group[first] < 0:
            count = _flooded(points, first, reach, group, waiting)
            if count > most:
                most, largest = count, first
    mask: NDArray[np.bool_] = group == largest
    return mask


@njit(cache=True)
def _flooded(
    points: Array,
    first: int,
    reach: float,
    group: NDArray[np.int64],
    waiting: NDArray[np.int64],
) -> int:
    """Write the group of one point, whose number is the group's; the number of its points."""
    group[first], waiting[0] = first, first
    done, count = 0, 1
    while done < count:
        here = points[waiting[done]]
        done += 1
        for i in range(len(points)):
            if group[i] < 0 and _square(points[i], here) <= reach * reach:
                group[i], waiting[count] = first, i
                count += 1
    return count


@njit(cache=True)
def _neighbours(points: Array, first: int, reach: float) -> Array:
    """The points within reach of one of them."""
    near, count = np.empty_like(points), 0
    for i in range(len(points)):
        if _square(points[i], points[first]) <= reach * reach:
            near[count] = points[i]
            count += 1
    return near[:count]


@njit(cache=True)
def _square(first: Array, second: Array) -> float:
    """Square of the distance of two points."""
    total = 0.0
    for axis in range(3):
        total += (first[axis] - second[axis]) ** 2
    return total


@njit(cache=True)
def votes_for(points: Array, point: Array, normal: Array, reach: float) -> Array:
    """Vote (N,) of each point for a plane."""
    votes = np.empty(len(points))
    offset = point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]
    for i in range(len(points)):
        along = points[i, 0] * normal[0] + points[i, 1] * normal[1] + points[i, 2] * normal[2]
        votes[i] = max(1.0 - ((along - offset) / reach) ** 2, 0.0)
    return votes


@njit(cache=True)
def sum_of_votes(points: Array, point: Array, normal: Array, reach: float) -> float:
    """Sum of the votes of all points, without a list of them."""
    total, scale = 0.0, 1.0 / reach
    a, b, c = normal[0] * scale, normal[1] * scale, normal[2] * scale
    offset = a * point[0] + b * point[1] + c * point[2]
    for i in range(len(points)):
        away = a * points[i, 0] + b * points[i, 1] + c * points[i, 2] - offset
        total += max(1.0 - away * away, 0.0)
    return total
