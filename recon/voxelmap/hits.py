"""Sums over the points of each cell: integers, so independent of the order."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap.table import CellTable, Rows, Slots, find_or_add

STEPS = 1 << 20
"""Steps per cell along each axis: positions in a cell are integer numbers of steps."""

NARROW = np.dtype([("index", "i4", 3), ("count", "u4"), ("position", "u4", 3), ("colour", "u4", 3)])
"""Position sums can hold 4096 points: enough for nearly every map, at 40 bytes per cell."""

WIDE = np.dtype([("index", "i4", 3), ("count", "u4"), ("position", "u8", 3), ("colour", "u8", 3)])

CAPACITY = {NARROW: 2**32 // STEPS, WIDE: 2**32 - 1}
"""Points that a row of each type can hold."""


@njit(cache=True)
def _steps(place: float) -> np.uint32:
    """Steps from the lower border of the cell; just below 0 the difference rounds to 1."""
    return np.uint32(min((place - np.floor(place)) * STEPS, STEPS - 1.0))


@njit(cache=True)
def _add(rows: Rows, row: int, steps: tuple[int, int, int], colour: NDArray[np.uint8]) -> None:
    sums = rows[row]
    sums.count += 1
    for a in range(3):
        sums.position[a] += steps[a]
        sums.colour[a] += colour[a]


@njit(cache=True)
def insert(
    cloud: tuple[NDArray[np.float64], NDArray[np.uint8], float],
    capacity: int,
    table: tuple[Slots, Rows, int],
    rows_of: NDArray[np.int64],
    start: int,
) -> tuple[int, int]:
    """Add points starting at `start`; stop at the first that does not fit.

    Parameters
    ----------
    cloud
        Points (N, 3), their colours (N, 3), and the size of a cell.
    capacity
        Points that a row can hold.
    table
        The arrays of the `CellTable`.
    rows_of
        (N,) output: the row of each point.

    Returns
    -------
    stop, num_rows
        The point that did not fit: no free row if `num_rows == len(rows)`, otherwise its row is
        full. `len(points)` if all are added.
    """
    points, colours, cell_size = cloud
    slots, rows, num_rows = table
    for n in range(start, len(points)):
        if num_rows == len(rows):
            return n, num_rows
        x, y, z = points[n, 0] / cell_size, points[n, 1] / cell_size, points[n, 2] / cell_size
        index = (np.int32(np.floor(x)), np.int32(np.floor(y)), np.int32(np.floor(z)))
        row, num_rows = find_or_add(slots, rows, num_rows, index)
        if rows[row].count >= capacity:
            return n, num_rows
        rows_of[n] = row
        _add(rows, row, (_steps(x), _steps(y), _steps(z)), colours[n])
    return len(points), num_rows


@njit(cache=True)
def merge(
    other: Rows,
    capacity: int,
    table: tuple[Slots, Rows, int],
    rows_of: NDArray[np.int64],
    start: int,
) -> tuple[int, int]:
    """Add the sums of another map's rows starting at `start`, as `insert` does for points."""
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
        rows_of[n] = row
        sums.count += added.count
        for a in range(3):
            sums.position[a] += added.position[a]
            sums.colour[a] += added.colour[a]
    return len(other), num_rows


class HitTable(CellTable):
    """A table of these sums, which become wider if a cell has many points."""

    def insert(
        self, points: NDArray[np.float64], colours: NDArray[np.uint8], cell_size: float
    ) -> NDArray[np.int64]:
        """Add points (N, 3) with their colours (N, 3); the row of each."""
        return self._add(insert, (points, colours, cell_size), len(points))

    def merge(self, rows: Rows) -> NDArray[np.int64]:
        """Add the sums of other cells; the row of each."""
        if rows.dtype == WIDE and self.rows.dtype != WIDE:
            self._widen()
        return self._add(merge, rows, len(rows))

    def _add(self, kernel: Any, added: Any, num: int) -> NDArray[np.int64]:
        """Run a kernel over points or rows, making room where it stops; the row of each."""
        rows = np.empty(num, np.int64)
        stop = 0
        while stop < num:
            stop, self.num_rows = kernel(added, CAPACITY[self.rows.dtype], self.arrays, rows, stop)
            if stop < num and self.is_full:
                self.grow()
            elif stop < num:
                self._widen()
        return rows

    def _widen(self) -> None:
        if self.rows.dtype == WIDE:
            raise InputError(f"a cell contains more than {CAPACITY[WIDE]} points")
        self.widen(WIDE)


def means(rows: Rows) -> NDArray[np.float64]:
    """Mean position (K, 3) as a fraction of the cell; a position is the centre of its step."""
    counts = rows["count"][:, None].astype(np.float64)
    return (rows["position"] / counts + 0.5) / STEPS


def mean_colours(rows: Rows) -> NDArray[np.uint8]:
    """Mean RGB (K, 3), rounded in integer arithmetic."""
    counts = rows["count"][:, None].astype(np.uint64)
    rounded = (2 * rows["colour"].astype(np.uint64) + counts) // (2 * counts)
    return rounded.astype(np.uint8)


def check_sums(rows: Rows) -> None:
    """Raise `InputError` if sums cannot result from points, as in a modified file."""
    counts = rows["count"][:, None].astype(np.uint64)
    is_possible = (
        (counts > 0)
        & (rows["position"] <= counts * np.uint64(STEPS - 1))
        & (rows["colour"] <= counts * np.uint64(255))
    ).all(axis=1)
    if not is_possible.all():
        index = rows["index"][np.argmin(is_possible)].tolist()
        raise InputError(f"the sums of cell {index} cannot come from points")
