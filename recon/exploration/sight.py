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
def cast(blocking: Mask, places: Array, azimuths: Array, radii: Array) -> Cells:
    """Flat index (C, A, R) of the cell under each sample of each ray; HIDDEN if not seen."""
    cell = np.empty((len(places), len(azimuths), len(radii)), np.int32)
    for c in range(len(places)):
        for a in range(len(azimuths)):
            _march(blocking, places[c], azimuths[a], radii, cell[c, a])
    return cell


@njit(cache=True)
def _along(cell: Cells, unknown: Mask, area: Array) -> float:
    """Unknown area along one ray, whose samples (R,) each represent an area."""
    total = 0.0
    for r in range(len(cell)):
        if cell[r] != HIDDEN and unknown[cell[r]]:
            total += area[r]
    return total


@njit(cache=True)
def fields(cell: Cells, places: NDArray[np.intp], unknown: Mask, area: Array, half: int) -> Array:
    """Unknown area (C, A) in the field of a view along each ray: `half` rays on both sides.

    Parameters
    ----------
    places : (P,) int
        Rows of the positions to compute; others are zero.
    unknown : (X * Z,) bool
    area : (R,) float64
        Area that each sample represents.
    """
    num_places, num_rays, _ = cell.shape
    field = np.zeros((num_places, num_rays))
    along = np.empty(num_rays)
    for c in places:
        for a in range(num_rays):
            along[a] = _along(cell[c, a], unknown, area)
        for a in range(num_rays):
            for turn in range(-half, half + 1):
                field[c, a] += along[(a + turn) % num_rays]
    return field


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
