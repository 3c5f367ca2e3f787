"""Compiled loops for planning: lines of sight over the floor, and what is seen along them.

Positions and lengths are in cells, relative to the floor's corner.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.exploration.floor import RAY_SPACING, ROUNDING, Array, Mask

HIDDEN = -1
Cells = NDArray[np.int32]
Rays = tuple[Cells, Cells, Cells]
"""Unknown cells, their samples and their number along rays, as `cast` gives them."""
Best = tuple[Array, NDArray[np.intp]]
"""Highest value (C,) of a view from each position, and its ray (C,)."""


@njit(cache=True)
def _march(blocking: Mask, place: Array, azimuth: float, radii: Array, cell: Cells) -> None:
    """Write the flat index of the cell under each visible sample of a ray to `cell` (R,).

    Obstacles above the position (2,) itself do not hide the floor around it.
    """
    size_x, size_z = blocking.shape
    dx, dz = math.cos(azimuth), math.sin(azimuth)
    came_out = False
    cell[:] = HIDDEN
    for r in range(len(radii)):
        x = int(np.floor(place[0] + dx * radii[r] + ROUNDING))
        z = int(np.floor(place[1] + dz * radii[r] + ROUNDING))
        is_free = 0 <= x < size_x and 0 <= z < size_z and not blocking[x, z]
        if came_out and not is_free:
            break
        came_out = is_free
        if is_free:
            cell[r] = x * size_z + z


@njit(cache=True)
def cast(blocking: Mask, unknown: Mask, places: Array, azimuths: Array, radii: Array) -> Rays:
    """Unknown cells (X * Z,) that are visible along rays from some positions.

    Returns
    -------
    cell, sample : (C, A, R) int32
        Flat indices of the unknown cells on each ray, and the samples in them.
    number : (C, A) int32
        Their number on each ray; the values after them are undefined.
    """
    shape = (len(places), len(azimuths), len(radii))
    cell, sample = np.empty(shape, np.int32), np.empty(shape, np.int32)
    number = np.zeros(shape[:2], np.int32)
    seen = np.empty(len(radii), np.int32)
    for c in range(len(places)):
        for a in range(len(azimuths)):
            _march(blocking, places[c], azimuths[a], radii, seen)
            number[c, a] = _pick(seen, unknown, cell[c, a], sample[c, a])
    return cell, sample, number


@njit(cache=True)
def _pick(seen: Cells, unknown: Mask, cell: Cells, sample: Cells) -> int:
    """Put the unknown ones of the visible cells (R,) into `cell` and `sample`; their number."""
    number = 0
    for r in range(len(seen)):
        if seen[r] != HIDDEN and unknown[seen[r]]:
            cell[number], sample[number] = seen[r], r
            number += 1
    return number


@njit(cache=True)
def _along(cell: Cells, sample: Cells, unknown: Mask, area: Array) -> float:
    """Unknown area along one ray, whose samples each represent an area (R,)."""
    total = 0.0
    for k in range(len(cell)):
        if unknown[cell[k]]:
            total += area[sample[k]]
    return total


@njit(cache=True)
def _sweep(along: Array, half: int, field: Array) -> None:
    """Set each ray's `field` (A,) to the areas along it and along `half` rays on both sides."""
    number = len(along)
    total = 0.0
    for turn in range(-half, half + 1):
        total += along[turn % number]
    for a in range(number):
        field[a] = total
        total += along[(a + half + 1) % number] - along[(a - half) % number]


@njit(cache=True)
def _field(rays: Rays, place: int, unknown: Mask, area: Array, half: int, field: Array) -> None:
    """Set `field` (A,) to the unknown area of a view from one position along each ray."""
    cell, sample, number = rays
    along = np.zeros(len(field))
    if number[place].max() > 0:
        for a in range(len(field)):
            own = slice(0, number[place, a])
            along[a] = _along(cell[place, a, own], sample[place, a, own], unknown, area)
    _sweep(along, half, field)


@njit(cache=True)
def fields(rays: Rays, places: NDArray[np.intp], unknown: Mask, area: Array, half: int) -> Array:
    """Unknown area (C, A) in the field of a view along each ray: `half` rays on both sides.

    Parameters
    ----------
    rays : (cell, sample, number)
        As `cast` gives them.
    places : (P,) int
        Rows of the positions to compute; others are zero.
    unknown : (X * Z,) bool
        Cells still unknown, of those that the rays were cast for.
    area : (R,) float64
        Area that each sample represents.
    """
    field = np.zeros(rays[2].shape)
    for c in places:
        _field(rays, c, unknown, area, half, field[c])
    return field


@njit(cache=True)
def _first_best(values: Array, slack: float) -> int:
    """Index of the first value that is the maximum up to a slack."""
    highest = values.max()
    for number in range(len(values)):
        if values[number] >= highest - slack:
            return number
    return 0


@njit(cache=True)
def _look_again(
    rays: Rays, place: int, unknown: Mask, area: Array, half: int, barred: Mask, best: Best
) -> None:
    """Set the best view from one position, of those not `barred` (A,)."""
    field = np.empty(len(barred))
    _field(rays, place, unknown, area, half, field)
    field[barred] = 0.0
    ray = _first_best(field, ROUNDING * field.max())
    best[0][place], best[1][place] = field[ray], ray


@njit(cache=True)
def best_fields(rays: Rays, unknown: Mask, area: Array, half: int, barred: Mask) -> Best:
    """The views that show most unknown area, of those not `barred` (C, A)."""
    number = len(barred)
    best = (np.zeros(number), np.zeros(number, np.intp))
    for c in range(number):
        _look_again(rays, c, unknown, area, half, barred[c], best)
    return best


@njit(cache=True)
def best_place(
    rays: Rays,
    unknown: Mask,
    area: Array,
    half: int,
    barred: Mask,
    best: Best,
    costs: tuple[Array, Array],
) -> int:
    """Position whose view shows most unknown area for its cost; -1 if none shows enough.

    What is left to see only shrinks: views are looked at again only where they decide.

    Parameters
    ----------
    best : Best
        The best views while more was unknown; updated where they are looked at again.
    costs : (C,), (C,)
        Cost of each position, and the area that a view from it has to show.
    """
    cost, least = costs
    is_new = np.zeros(len(cost), np.bool_)
    score = np.where(best[0] >= least, best[0] / cost, 0.0)
    while True:
        c = _first_best(score, ROUNDING * score.max())
        if is_new[c] or score[c] == 0.0:
            return c if score[c] > 0.0 else -1
        _look_again(rays, c, unknown, area, half, barred[c], best)
        score[c], is_new[c] = best[0][c] / cost[c] if best[0][c] >= least[c] else 0.0, True


@njit(cache=True)
def update_best(
    best: Best,
    places: NDArray[np.intp],
    sides: Array,
    ground: Array,
    barred: Mask,
    side_area: float,
) -> None:
    """Set the best views from some positions, of those that show a side and are not `barred`.

    Parameters
    ----------
    best : Best
        Updated in place.
    sides, ground : (C, A), (C, A)
        Number of sides and area of ground that a view along each ray shows; a side counts as
        `side_area`.
    """
    for c in places:
        worth = np.where((sides[c] > 0.0) & ~barred[c], side_area * sides[c] + ground[c], 0.0)
        ray = _first_best(worth, ROUNDING * worth.max())
        best[0][c], best[1][c] = worth[ray], ray


@njit(cache=True)
def see(unknown: Mask, blocking: Mask, place: Array, azimuths: Array, radii: Array) -> None:
    """Remove the cells seen by rays from a position (2,) from `unknown` (X * Z,), in place."""
    cell = np.empty(len(radii), np.int32)
    for a in range(len(azimuths)):
        _march(blocking, place, azimuths[a], radii, cell)
        for number in cell:
            if number != HIDDEN:
                unknown[number] = False


@njit(cache=True)
def are_open(occupied: Mask, starts: Array, ends: Array, own: Array, wanted: Mask) -> Mask:
    """Mask (O, C) of the free ones of the `wanted` lines of sight from positions to others.

    Parameters
    ----------
    starts, ends : (C, 2), (O, 2)
    own : (O,)
        Length at the end of the lines where occupied cells do not block them.
    """
    is_seen = np.zeros_like(wanted)
    for o in range(len(ends)):
        for c in range(len(starts)):
            is_seen[o, c] = wanted[o, c] and is_open(occupied, starts[c], ends[o], own[o])
    return is_seen


@njit(cache=True)
def is_open(occupied: Mask, start: Array, end: Array, own: float) -> bool:
    """True if no occupied cell is between two positions, except `own` cells at the end."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    for step in range(int((length - own) / RAY_SPACING)):
        share = step * RAY_SPACING / length
        x = int(np.floor(start[0] + share * (end[0] - start[0]) + ROUNDING))
        z = int(np.floor(start[1] + share * (end[1] - start[1]) + ROUNDING))
        inside = 0 <= x < occupied.shape[0] and 0 <= z < occupied.shape[1]
        if inside and occupied[x, z]:
            return False
    return True
