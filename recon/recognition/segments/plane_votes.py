"""The plane that most points vote for, among those of the neighbourhoods of all points, compiled.

No plane is drawn at random, so that the one found changes little where the points change little.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.principal_axes import principal_axes, weighted_spread
from recon.recognition.segments.local_planes import REORDERED

Array = NDArray[np.float64]

MOST_ROUNDS = 10
"""Most fits of the best plane to all points."""


@njit(cache=True)
def tally(points: Array, middles: Array, normals: Array, reach: float) -> Array:
    """Sum (P,) of the votes of points (N, 3) for each of some planes (P, 3)."""
    columns, totals = np.ascontiguousarray(points.T), np.empty(len(middles))
    for plane in range(len(middles)):
        totals[plane] = sum_of_votes(columns, middles[plane], normals[plane], reach)
    return totals


@njit(cache=True)
def settled_plane(
    points: Array, point: Array, normal: Array, is_upright: bool, reach: float
) -> tuple[Array, Array]:
    """A plane fitted to the points that vote for it, again and again while votes grow.

    Closer points count more: a plane across an edge is near many points but close to few.

    Parameters
    ----------
    points : (N, 3)
    point, normal : (3,)
    is_upright : bool
        Keep the plane upright.
    reach : float
        Distance up to which points vote.

    Returns
    -------
    point, normal : (3,)
    """
    columns = np.ascontiguousarray(points.T)
    best = sum_of_votes(columns, point, normal, reach)
    for _ in range(MOST_ROUNDS):
        middle, across = fitted_plane(points, votes_for(points, point, normal, reach), is_upright)
        total = sum_of_votes(columns, middle, across, reach)
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


@njit(cache=True, fastmath=REORDERED)
def sum_of_votes(columns: Array, point: Array, normal: Array, reach: float) -> float:
    """Sum of the votes of all points, given as x, y and z (3, N), without a list of them."""
    total, scale = 0.0, 1.0 / reach
    a, b, c = normal[0] * scale, normal[1] * scale, normal[2] * scale
    offset = a * point[0] + b * point[1] + c * point[2]
    x, y, z = columns
    for i in range(len(x)):
        away = a * x[i] + b * y[i] + c * z[i] - offset
        total += max(1.0 - away * away, 0.0)
    return total
