"""Compiled loops: a map drawn as it is seen from a pose, and how well a pair agrees with it.

Directions are columns of azimuth and rows of slope (height over horizontal distance), both with the
same side; a level camera's image keeps its form in them when the camera turns.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Spans = tuple[tuple[int, int], tuple[int, int]]
"""First and last column, first and last row."""

MOST_SIGMAS_SQ = 9.0
"""Squared distance from which on a point does not agree at all."""
ASIDE = 0.7
"""Squared distance of a neighbouring direction."""
ROUGHNESS_SQ = 0.16
"""Variance of the distance of a surface, square cells."""
LEAST_RANGE = 0.7
"""Cells nearer than this many cells are ignored."""
MISSING = 0.3
"""Weight of what should be seen and is not, relative to what is seen ..."""
USUAL_WIDTH = 6.0
"""... for objects of this width in cells."""
MOST_ROUNDS = 12
MOST_WIDE = 0.4
"""Most radians, to each side, within which a coarse cell is drawn."""
LEAST_BOUND = 0.5
"""Share of the greatest possible agreement below which a bound is not computed to the end."""


class Grid(NamedTuple):
    """A grid of directions."""

    side: float
    """Radians of a column, and slope of a row."""
    first: int
    """Azimuth of the first column, in columns, relative to straight ahead."""
    lowest: float
    """Slope at the lower end of the first row."""
    num_columns: int
    num_rows: int


class Seen(NamedTuple):
    """The view of a pair in the directions of a grid."""

    column: Indices
    """(N,) of the points."""
    row: Indices
    range: Array
    """(N,) horizontal distance of the points, world units."""
    sigma: Array
    weight: Array
    empty: Indices
    """(M, 2) columns and rows, inside the field of view, with nothing near them."""
    pivot: Array
    """(2,) ahead and aside: middle of what is nearest; poses may turn about it."""


class Views(NamedTuple):
    """The views of a pair, one for each of several pitches of its camera."""

    seen: Seen
    """Of all views, one after the other."""
    points: Indices
    """(V + 1,) first points of the views, and the end."""
    empty: Indices
    """(V + 1,) the same of empty directions."""


class Shape(NamedTuple):
    """Surfaces of a map."""

    points: Array
    """(K, 3) world."""
    size: float
    """Of their cells, world units."""


@njit(cache=True, nogil=True)
def _span(middle: float, half: float, side: float) -> tuple[int, int]:
    return math.floor((middle - half) / side), math.floor((middle + half) / side)


@njit(cache=True, nogil=True)
def draw(shape: Shape, place: Array, height: float, grid: Grid, near: Array) -> None:
    """Write the distance of the nearest surface in each direction to `near` (A, E)."""
    near[:] = np.inf
    for k in range(len(shape.points)):
        dx, dz = shape.points[k, 0] - place[0], shape.points[k, 2] - place[1]
        away = math.sqrt(dx * dx + dz * dz)
        if away < LEAST_RANGE * shape.size:
            continue
        half = 0.4 * shape.size / away
        turn = math.atan2(dz, dx) - place[2]
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        left, right = _span(turn, half, grid.side)
        slope = (shape.points[k, 1] - height) / away - grid.lowest
        low, high = _span(slope, half, grid.side)
        for a in range(max(left - grid.first, 0), min(right - grid.first + 1, grid.num_columns)):
            for e in range(max(low, 0), min(high + 1, grid.num_rows)):
                near[a, e] = min(near[a, e], away)


@njit(cache=True, nogil=True)
def _distance_sq(seen: Seen, i: int, near: Array, rough_sq: float) -> float:
    """Squared standard deviations from a point to the surface drawn nearest to it."""
    best = MOST_SIGMAS_SQ
    for da in range(-2, 3):
        for de in range(-2, 3):
            a, e = seen.column[i] + da, seen.row[i] + de
            if 0 <= a < near.shape[0] and 0 <= e < near.shape[1] and near[a, e] < np.inf:
                off = seen.range[i] - near[a, e]
                off_sq = off * off / (seen.sigma[i] ** 2 + rough_sq)
                best = min(best, off_sq + ASIDE * (da * da + de * de))
    return best


@njit(cache=True, nogil=True)
def agreement(
    shape: Shape, place: Array, height: float, grid: Grid, seen: Seen, near: Array
) -> float:
    """Log likelihood, up to a constant, of what a pair sees from a place x, z, azimuth (3,)."""
    draw(shape, place, height, grid, near)
    rough_sq, value = ROUGHNESS_SQ * shape.size**2, 0.0
    for i in range(len(seen.column)):
        off_sq = _distance_sq(seen, i, near, rough_sq)
        value += seen.weight[i] * (1.0 - 2.0 * off_sq / MOST_SIGMAS_SQ)
    scale = MISSING * grid.side / (USUAL_WIDTH * shape.size)
    for i in range(len(seen.empty)):
        away = near[seen.empty[i, 0], seen.empty[i, 1]]
        if away < np.inf:
            value -= scale * away
    return value


@njit(cache=True, nogil=True)
def _moved(place: Array, way: int, step: float, pivot: Array) -> Array:
    """A place after a step ahead, aside, around itself or around the pivot (way // 2)."""
    if way % 2:
        step = -step
    c, s = math.cos(place[2]), math.sin(place[2])
    ahead = step if way < 2 else 0.0
    aside = step if 2 <= way < 4 else 0.0
    away = max(math.hypot(pivot[0], pivot[1]), 1e-9)
    turn = 0.0 if way < 4 else step / away
    end = np.array([place[0] + c * ahead - s * aside, place[1] + s * ahead + c * aside, place[2]])
    end[2] += turn
    if way >= 6:
        c2, s2 = math.cos(end[2]), math.sin(end[2])
        end[0] += (c - c2) * pivot[0] - (s - s2) * pivot[1]
        end[1] += (s - s2) * pivot[0] + (c - c2) * pivot[1]
    return end


@njit(cache=True, nogil=True)
def climb(
    shape: Shape, start: Array, height: float, grid: Grid, seen: Seen, step: float
) -> tuple[Array, float]:
    """The place of best agreement that steps lead to, and its agreement."""
    near = np.empty((grid.num_columns, grid.num_rows))
    place, value = start, agreement(shape, start, height, grid, seen, near)
    for _ in range(MOST_ROUNDS):
        best, most = place, value
        for way in range(8):
            other = _moved(place, way, step, seen.pivot)
            here = agreement(shape, other, height, grid, seen, near)
            if here > most + 1e-9:
                best, most = other, here
        if most <= value:
            break
        place, value = best, most
    return place, value


@njit(cache=True, nogil=True)
def _panorama(
    shape: Shape, place: Array, grid: Grid, slack: float, drawn: tuple[Array, Array, Array]
) -> None:
    """Draw everything around a place: nearest surfaces, and ranges that may be within reach.

    `place` is x, y, z; `drawn` are the nearest distance, and the lowest and highest distance in
    each direction from anywhere within `slack` of the place.
    """
    near, low, high = drawn
    near[:], low[:], high[:] = np.inf, np.inf, 0.0
    for k in range(len(shape.points)):
        dx, dz = shape.points[k, 0] - place[0], shape.points[k, 2] - place[2]
        away = math.sqrt(dx * dx + dz * dz)
        if away < shape.size / 2.0:
            continue
        turn, slope = math.atan2(dz, dx), (shape.points[k, 1] - place[1]) / away
        half = 0.5 * shape.size / away
        wide = min((0.5 * shape.size + slack) / away, MOST_WIDE)
        tall = wide * max(0.3, abs(slope) + half)
        slope -= grid.lowest
        _widen(
            drawn, (_span(turn, wide, grid.side), _span(slope, max(tall, half), grid.side)), away
        )
        _place(near, (_span(turn, half, grid.side), _span(slope, half, grid.side)), away)


@njit(cache=True, nogil=True)
def _widen(drawn: tuple[Array, Array, Array], spans: Spans, away: float) -> None:
    """Extend the ranges of all directions in some columns and rows to a distance."""
    _, low, high = drawn
    for column in range(spans[0][0], spans[0][1] + 1):
        a = column % low.shape[0]
        for e in range(max(spans[1][0], 0), min(spans[1][1] + 1, low.shape[1])):
            low[a, e], high[a, e] = min(low[a, e], away), max(high[a, e], away)


@njit(cache=True, nogil=True)
def _place(near: Array, spans: Spans, away: float) -> None:
    """Put a surface in some columns and rows, where nothing nearer is."""
    for column in range(spans[0][0], spans[0][1] + 1):
        a = column % near.shape[0]
        for e in range(max(spans[1][0], 0), min(spans[1][1] + 1, near.shape[1])):
            near[a, e] = min(near[a, e], away)


@njit(cache=True, nogil=True)
def _turned(
    grid: Grid, views: Views, view: int, slack: float, drawn: tuple[Array, Array, Array], turn: int
) -> float:
    """Upper bound of the agreement of a view with a panorama after a turn by some columns."""
    near, low, high = drawn
    seen, points, empty = views.seen, views.points[view : view + 2], views.empty[view : view + 2]
    value = float(seen.weight[points[0] : points[1]].sum())
    least = LEAST_BOUND * value
    for i in range(points[0], points[1]):
        a, e = (seen.column[i] + turn) % grid.num_columns, seen.row[i]
        reach = slack + 2.5 * seen.sigma[i]
        if not low[a, e] - reach <= seen.range[i] <= high[a, e] + reach:
            value -= 2.0 * seen.weight[i]
            if value < least:
                return -np.inf
    scale = MISSING * grid.side / (USUAL_WIDTH * slack)
    for i in range(empty[0], empty[1]):
        away = near[(seen.empty[i, 0] + turn) % grid.num_columns, seen.empty[i, 1]]
        if away < np.inf:
            value -= scale * away
    return value


@njit(cache=True, nogil=True)
def sweep(
    shape: Shape, places: Array, slack: float, grid: Grid, views: Views
) -> NDArray[np.float32]:
    """Upper bounds (P, V, A) of the agreement within `slack` of places (P, 3), x, y, z.

    For each view and heading; the grid goes all round, and the columns of what is seen are relative
    to the heading.
    """
    num_views = len(views.points) - 1
    value = np.empty((len(places), num_views, grid.num_columns), np.float32)
    size = (grid.num_columns, grid.num_rows)
    drawn = (np.empty(size), np.empty(size), np.empty(size))
    for p in range(len(places)):
        _panorama(shape, places[p], grid, slack, drawn)
        for view in range(num_views):
            for turn in range(grid.num_columns):
                value[p, view, turn] = _turned(grid, views, view, slack, drawn, turn)
    return value
