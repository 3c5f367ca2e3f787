"""Planes of an object, removed one after the other, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.principal_axes import principal_axes, weighted_spread
from recon.recognition.segments.plane_votes import (
    fitted_plane,
    largest_group,
    settled_plane,
    tally,
)

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

ON_PLANE_CELLS = 0.5
"""Maximum distance of a cell on a plane."""
LINK_CELLS = 2.0
LEAST_WIDTH_CELLS = 1.8
"""Narrower strips are bars, not planes."""
MOST_PLANES = 10
ALIKE = 0.9
"""Cosine of the angle below which planes through the same cells are one and the same."""


@njit(cache=True)
def peeled(
    points: Array, middles: Array, normals: Array, is_upright: bool, cell_size: float, least: int
) -> tuple[Array, Array, Rows]:
    """At most `MOST_PLANES` planes, each the one that most of the points left vote for.

    Strips, and points that do not hang together, are out of the choice.

    Parameters
    ----------
    points : (N, 3)
    middles, normals : (P, 3)
        The planes to choose from; row n, modulo N, is that of point n.
    is_upright : bool
        Keep the planes upright.
    least : int
        Minimum number of points of a plane.

    Returns
    -------
    places, directions : (F, 3)
        A point and the normal of each plane.
    number : (N,) plane of each point; -1 = on none
    """
    places, directions = np.empty((MOST_PLANES, 3)), np.empty((MOST_PLANES, 3))
    number = np.full(len(points), -1)
    is_open = np.ones(len(middles), dtype=np.bool_)
    count, reach = 0, ON_PLANE_CELLS * cell_size
    votes = tally(points, middles, normals, reach)
    for _ in range(MOST_PLANES):
        rest = np.flatnonzero(number < 0)
        if len(rest) < least or not is_open.any():
            break
        some, best = points[rest], np.argmax(np.where(is_open, votes, -1.0))
        place, normal = settled_plane(some, middles[best], normals[best], is_upright, reach)
        near = near_plane(some, place, normal, reach)
        own = _surface(some, near, is_upright, cell_size, least)
        if len(own):
            place, direction = fitted_plane(some[own], np.ones(len(own)), is_upright)
            places[count], directions[count] = place, direction
            number[rest[own]] = count
            count += 1
            _close(is_open, rest[own], len(points))
            choice = np.flatnonzero(is_open)
            votes[choice] -= tally(some[own], middles[choice], normals[choice], reach)
        else:
            _close_alike(is_open, normals, normal, rest[near], len(points))
    return places[:count], directions[:count], number


@njit(cache=True)
def near_plane(points: Array, place: Array, normal: Array, reach: float) -> Rows:
    """Rows of the points within reach of a plane."""
    rows, count = np.empty(len(points), dtype=np.int64), 0
    for i in range(len(points)):
        away = 0.0
        for k in range(3):
            away += (points[i, k] - place[k]) * normal[k]
        if abs(away) < reach:
            rows[count] = i
            count += 1
    near: Rows = rows[:count]
    return near


@njit(cache=True)
def _surface(points: Array, near: Rows, is_upright: bool, cell_size: float, least: int) -> Rows:
    """Rows of connected points of one plane; none if they are too few or a strip.

    Parameters
    ----------
    near : (N,)
        Rows of the points that it is first fitted to.
    """
    none: Rows = np.empty(0, dtype=np.int64)
    if len(near) < least:
        return none
    place, normal = fitted_plane(points[near], np.ones(len(near)), is_upright)
    own = near_plane(points, place, normal, ON_PLANE_CELLS * cell_size)
    if len(own) < least:
        return none
    group: Rows = own[largest_group(points[own], LINK_CELLS * cell_size)]
    if len(group) < least or width(points[group]) < LEAST_WIDTH_CELLS * cell_size:
        return none
    return group


@njit(cache=True)
def width(points: Array) -> float:
    """Width of a uniform strip: its standard deviation times the root of 12."""
    spread = principal_axes(weighted_spread(points, np.ones(len(points)))[1])[0]
    width: float = np.sqrt(12.0 * max(spread[1], 0.0) / len(points))
    return width


@njit(cache=True)
def _close(is_open: NDArray[np.bool_], rows: Rows, num_points: int) -> None:
    """Take the planes of some points out of the choice."""
    for row in rows:
        is_open[row::num_points] = False


@njit(cache=True)
def _close_alike(
    is_open: NDArray[np.bool_], normals: Array, normal: Array, rows: Rows, num_points: int
) -> None:
    """Take those of the planes of some points that are like one plane out of the choice."""
    for row in rows:
        for plane in range(row, len(normals), num_points):
            cosine = 0.0
            for k in range(3):
                cosine += normals[plane, k] * normal[k]
            if abs(cosine) > ALIKE:
                is_open[plane] = False
