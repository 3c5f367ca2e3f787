"""What every cell keeps of the points in it: sums of whole numbers, the same in any order."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.voxelmap.table import Rows, Slots, find_or_add

STEPS = 1 << 20
"""Steps of a cell along each axis: a position inside it is a whole number of them."""

NARROW = np.dtype([("index", "i4", 3), ("count", "u4"), ("position", "u4", 3), ("colour", "u4", 3)])
"""Sums of positions hold 4096 points: enough for nearly every map, at 40 bytes a cell."""

WIDE = np.dtype([("index", "i4", 3), ("count", "u4"), ("position", "u8", 3), ("colour", "u8", 3)])

CAPACITY = {NARROW: 2**32 // STEPS, WIDE: 2**32 - 1}
"""Points that a row of each type can hold."""


@njit(cache=True)
def insert(
    points: NDArray[np.float64],
    colours: NDArray[np.uint8],
    cell_size: float,
    capacity: int,
    table: tuple[Slots, Rows, int],
    start: int,
) -> tuple[int, int]:
    """Add points from `start` on; stop at the first that finds no room.

    Returns
    -------
    stop, num_rows
        The point that found no room: for a new row where `num_rows == len(rows)`, otherwise in a
        row that holds `capacity` points. `len(points)` when all are in.
    """
    slots, rows, num_rows = table
    place = np.empty(3)
    cell = np.empty(3)
    for n in range(start, len(points)):
        if num_rows == len(rows):
            return n, num_rows
        for a in range(3):
            place[a] = points[n, a] / cell_size
            cell[a] = np.floor(place[a])
        index = (np.int32(cell[0]), np.int32(cell[1]), np.int32(cell[2]))
        row, num_rows = find_or_add(slots, rows, num_rows, index)
        sums = rows[row]
        if sums.count >= capacity:
            return n, num_rows
        sums.count += 1
        for a in range(3):
            # Just below 0 the difference rounds to a whole cell.
            step = min((place[a] - cell[a]) * STEPS, STEPS - 1.0)
            sums.position[a] += np.uint32(step)
            sums.colour[a] += colours[n, a]
    return len(points), num_rows


@njit(cache=True)
def merge(
    other: Rows, capacity: int, table: tuple[Slots, Rows, int], start: int
) -> tuple[int, int]:
    """Add the sums of another map's rows from `start` on; stops as `insert` does."""
    slots, rows, num_rows = table
    for n in range(start, len(other)):
        if num_rows == len(rows):
            return n, num_rows
        added = other[n]
        index = (added.index[0], added.index[1], added.index[2])
        row, num_rows = find_or_add(slots, rows, num_rows, index)
        sums = rows[row]
        if np.int64(sums.count) + np.int64(added.count) > capacity:
            return n, num_rows
        sums.count += added.count
        for a in range(3):
            sums.position[a] += added.position[a]
            sums.colour[a] += added.colour[a]
    return len(other), num_rows
