"""The cells that rays go through (Amanatides and Woo 1987), in whole numbers."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.voxelmap.table import Rows, Slots, find_or_add

# A ray's cells are counted from the eye's in one whole number, 21 bits along each axis.
_BITS = 21
_MIDDLE = 1 << (_BITS - 1)
_MASK = (1 << _BITS) - 1
_EYE_KEY = _MIDDLE << 2 * _BITS | _MIDDLE << _BITS | _MIDDLE
MAX_CELLS = _MIDDLE - 1
"""Longest ray, in cells along an axis."""

# Length of a ray in steps; a border beyond its end is never more than two lengths away.
_LENGTH = 1 << 60

# The memory is a block of 64 x 32 x 64 cells that is repeated endlessly over space.
_SEEN_BITS = (6, 5, 6)


def new_memory() -> NDArray[np.int64]:
    """Keys of the cells that one scan has counted, as far as they fit; none yet."""
    return np.full(1 << sum(_SEEN_BITS), -1)


@njit(cache=True)
def _count(
    table: tuple[Slots, Rows, int], index: tuple[int, int, int], scan: int, is_hit: bool
) -> int:
    """Count a cell unless this scan has counted it; returns the number of rows."""
    slots, rows, num_rows = table
    row, num_rows = find_or_add(slots, rows, num_rows, index)
    cell = rows[row]
    if cell.scan != scan:
        cell.scan = scan
        if is_hit:
            cell.hits += 1
        else:
            cell.passes += 1
    return int(num_rows)


@njit(cache=True)
def _seen_slot(key: int) -> int:
    """Where the memory keeps a cell."""
    x = (key >> 2 * _BITS) & ((1 << _SEEN_BITS[0]) - 1)
    y = (key >> _BITS) & ((1 << _SEEN_BITS[1]) - 1)
    z = key & ((1 << _SEEN_BITS[2]) - 1)
    return x | y << _SEEN_BITS[0] | z << (_SEEN_BITS[0] + _SEEN_BITS[1])


@njit(cache=True)
def hit_cells(
    origin: NDArray[np.float64],
    points: NDArray[np.float64],
    cell_size: float,
    scan: int,
    seen: NDArray[np.int64],
    table: tuple[Slots, Rows, int],
    start: int,
) -> tuple[int, int]:
    """Count the cells of the points; stops where there is no room for another."""
    slots, rows, num_rows = table
    eye = _cell_of(origin, cell_size)
    for n in range(start, len(points)):
        if num_rows == len(rows):
            return n, num_rows
        x, y, z = _cell_of(points[n], cell_size)
        key = _EYE_KEY + ((x - eye[0]) << 2 * _BITS) + ((y - eye[1]) << _BITS) + (z - eye[2])
        slot = _seen_slot(key)
        if seen[slot] != key:
            seen[slot] = key
            num_rows = _count((slots, rows, num_rows), (x, y, z), scan, True)
    return len(points), num_rows


@njit(cache=True)
def pass_cells(
    origin: NDArray[np.float64],
    ends: NDArray[np.float64],
    cell_size: float,
    scan: int,
    seen: NDArray[np.int64],
    table: tuple[Slots, Rows, int],
    start: int,
) -> tuple[int, int]:
    """Count the cells from the eye to before those of the ends; stops as `hit_cells` does."""
    slots, rows, num_rows = table
    eye = _cell_of(origin, cell_size)
    for n in range(start, len(ends)):
        num_x, way_x, border_x, step_x = _crossings(origin[0], ends[n, 0], cell_size)
        num_y, way_y, border_y, step_y = _crossings(origin[1], ends[n, 1], cell_size)
        num_z, way_z, border_z, step_z = _crossings(origin[2], ends[n, 2], cell_size)
        num = num_x + num_y + num_z
        if num_rows + num > len(rows):
            return n, num_rows
        key = _EYE_KEY
        for _ in range(num):
            slot = _seen_slot(key)
            if seen[slot] != key:
                seen[slot] = key
                x = (key >> 2 * _BITS) - _MIDDLE + eye[0]
                y = ((key >> _BITS) & _MASK) - _MIDDLE + eye[1]
                z = (key & _MASK) - _MIDDLE + eye[2]
                num_rows = _count((slots, rows, num_rows), (x, y, z), scan, False)
            # Without branches, as which border comes next cannot be foretold; equal ones are
            # crossed z first, then y, as OctoMap does.
            is_x = (border_x < border_y) & (border_x < border_z)
            is_y = (border_y < border_z) & (not is_x)
            is_z = not (is_x | is_y)
            border_x += step_x if is_x else 0
            border_y += step_y if is_y else 0
            border_z += step_z if is_z else 0
            key += (way_x << 2 * _BITS) if is_x else (way_y << _BITS) if is_y else way_z
    return len(ends), num_rows


@njit(cache=True)
def _cell_of(point: NDArray[np.float64], cell_size: float) -> tuple[int, int, int]:
    return (
        int(np.floor(point[0] / cell_size)),
        int(np.floor(point[1] / cell_size)),
        int(np.floor(point[2] / cell_size)),
    )


@njit(cache=True)
def _crossings(eye: float, end: float, cell_size: float) -> tuple[int, int, int, int]:
    """The borders of cells that a ray crosses along one axis.

    Returns
    -------
    num, way, first, step
        How many; -1, 0 or 1; the place of the first and the distance of two, as shares of the
        ray in units of `_LENGTH`.
    """
    first_cell = int(np.floor(eye / cell_size))
    num = abs(int(np.floor(end / cell_size)) - first_cell)
    if num == 0:
        return 0, 0, 2 * _LENGTH, 0
    reach = end - eye
    way = 1 if reach > 0 else -1
    border = (first_cell + (1 if reach > 0 else 0)) * cell_size
    first = int(min((border - eye) / reach, 1.0) * _LENGTH)
    step = int(min(cell_size / abs(reach), 1.0) * _LENGTH)
    return num, way, first, step


@njit(cache=True)
def merge_cells(other: Rows, table: tuple[Slots, Rows, int], start: int) -> tuple[int, int]:
    """Add the counts of another map's rows from `start` on; stops where there is no room."""
    slots, rows, num_rows = table
    for n in range(start, len(other)):
        if num_rows == len(rows):
            return n, num_rows
        added = other[n]
        index = (added.index[0], added.index[1], added.index[2])
        row, num_rows = find_or_add(slots, rows, num_rows, index)
        rows[row].hits += added.hits
        rows[row].passes += added.passes
    return len(other), num_rows
