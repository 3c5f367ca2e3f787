"""The cells that rays pass through (Amanatides and Woo 1987), in integer arithmetic."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.voxelmap.table import Rows, Slots, find_or_add

MAX_CELLS = (1 << 19) - 1
"""Longest ray, in cells along an axis, so that cell numbers of a scan's block fit 64 bits."""

# A block with more cells has no byte array; its cells are looked up in the table.
_MAX_MEMORY = 1 << 26

# Length of a ray in steps; a border beyond its end is at most two lengths away.
_LENGTH = 1 << 60

Block = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]
"""Lowest cell (3,) and shape (3,) of the box around a scan, and a flag for each of its cells that
the scan has counted; empty if the box is too large."""

Corners = tuple[NDArray[np.float64], NDArray[np.float64]]
Table = tuple[Slots, Rows, int]


@njit(cache=True)
def corners(eye: NDArray[np.float64], points: NDArray[np.float64]) -> Corners:
    """Lowest and highest corner (3,) of the box around the eye (3,) and the points (N, 3)."""
    low, high = eye.copy(), eye.copy()
    for n in range(len(points)):
        for a in range(3):
            low[a] = min(low[a], points[n, a])
            high[a] = max(high[a], points[n, a])
    return low, high


def block_of(ends: Corners, cell_size: float) -> Block:
    """The block of the cells between two corners (3,), with a margin of one cell.

    The margin is for rays that leave the box through rounding.
    """
    low, high = (np.floor(corner / cell_size).astype(np.int64) for corner in ends)
    shape = high - low + 3
    num = int(shape.prod())
    return low - 1, shape, np.zeros(num if num <= _MAX_MEMORY else 0, np.uint8)


@njit(cache=True)
def hit_cells(
    hits: tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.uint32]],
    cell_size: float,
    scan: int,
    block: Block,
    table: Table,
    start: int,
) -> tuple[int, int]:
    """Count the cells of points, starting at `start`, as hit by a scan.

    Parameters
    ----------
    hits
        The points (N, 3), the row of the map of each (N,), and for each row the last scan that hit
        it, which is updated and shows if a point is the first in its cell.

    Returns
    -------
    stop, num_rows
        The point that had no room for another row; `len(points)` if all are counted.
    """
    points, row_of, last_scan = hits
    seen = block[2]
    slots, rows, num_rows = table
    for n in range(start, len(points)):
        if last_scan[row_of[n]] == scan:
            continue
        if num_rows == len(rows):
            return n, num_rows
        last_scan[row_of[n]] = scan
        cell = _number_of(points[n], cell_size, block)
        _is_new(seen, cell)
        row, num_rows = find_or_add(slots, rows, num_rows, _index_of(cell, block))
        _count(rows, row, scan, True)
    return len(points), num_rows


@njit(cache=True)
def pass_cells(
    rays: tuple[NDArray[np.float64], NDArray[np.float64]],
    cell_size: float,
    scan: int,
    block: Block,
    table: Table,
    start: int,
) -> tuple[int, int]:
    """Count the cells from the camera (3,) up to, excluding, those of the ends (N, 3) as passed.

    Each cell counts once, and not at all if the scan has a point in it; returns as `hit_cells`.
    """
    eye, ends = rays
    _, shape, seen = block
    slots, rows, num_rows = table
    eye_cell = (
        _cell_of(eye[0], cell_size), _cell_of(eye[1], cell_size), _cell_of(eye[2], cell_size)
    )  # fmt: skip
    first = _number_of(eye, cell_size, block)
    for n in range(start, len(ends)):
        num_x, way_x, border_x, step_x = _crossings(eye[0], eye_cell[0], ends[n, 0], cell_size)
        num_y, way_y, border_y, step_y = _crossings(eye[1], eye_cell[1], ends[n, 1], cell_size)
        num_z, way_z, border_z, step_z = _crossings(eye[2], eye_cell[2], ends[n, 2], cell_size)
        num = num_x + num_y + num_z
        if num_rows + num > len(rows):
            return n, num_rows
        way_x, way_y = way_x * shape[1] * shape[2], way_y * shape[2]
        cell = first
        for _ in range(num):
            if _is_new(seen, cell):
                row, num_rows = find_or_add(slots, rows, num_rows, _index_of(cell, block))
                _count(rows, row, scan, False)
            # Bit masks, since a branch on the next border would be unpredictable; ties are crossed
            # z first, then y, as in OctoMap.
            is_x = -np.int64((border_x < border_y) & (border_x < border_z))
            is_y = -np.int64(border_y < border_z) & ~is_x
            is_z = ~(is_x | is_y)
            border_x += step_x & is_x
            border_y += step_y & is_y
            border_z += step_z & is_z
            cell += (way_x & is_x) | (way_y & is_y) | (way_z & is_z)
    return len(ends), num_rows


@njit(cache=True)
def merge_cells(other: Rows, table: Table, start: int) -> tuple[int, int]:
    """Add the counts of another map's rows starting at `start`; stop if there is no room."""
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


@njit(cache=True)
def _is_new(seen: NDArray[np.uint8], cell: int) -> bool:
    """True unless the scan is known to have counted a cell; marks the cell as counted."""
    if len(seen) == 0:
        return True
    # Unsigned indices avoid the check for negative ones.
    at = np.uint64(cell)
    is_new = seen[at] == 0
    seen[at] = 1
    return bool(is_new)


@njit(cache=True)
def _number_of(point: NDArray[np.float64], cell_size: float, block: Block) -> int:
    """The number of a point's cell in a block."""
    low, shape, _ = block
    x = _cell_of(point[0], cell_size) - low[0]
    y = _cell_of(point[1], cell_size) - low[1]
    z = _cell_of(point[2], cell_size) - low[2]
    return int((x * shape[1] + y) * shape[2] + z)


@njit(cache=True)
def _index_of(cell: int, block: Block) -> tuple[int, int, int]:
    """The index of the cell with this number."""
    low, shape, _ = block
    column, z = cell // shape[2], cell % shape[2]
    return (column // shape[1] + low[0], column % shape[1] + low[1], z + low[2])


@njit(cache=True)
def _count(rows: Rows, row: int, scan: int, is_hit: bool) -> None:
    """Count a cell unless this scan has already counted it."""
    if rows[row].scan == scan:
        return
    rows[row].scan = scan
    if is_hit:
        rows[row].hits += 1
    else:
        rows[row].passes += 1


@njit(cache=True)
def _cell_of(place: float, cell_size: float) -> int:
    return int(np.floor(place / cell_size))


@njit(cache=True)
def _crossings(
    eye: float, eye_cell: int, end: float, cell_size: float
) -> tuple[int, int, int, int]:
    """The cell borders that a ray crosses along one axis.

    Returns
    -------
    num, way, first, step
        Their number; -1, 0 or 1; the position of the first and the distance between two, along the
        ray in units of its length / `_LENGTH`.
    """
    num = _cell_of(end, cell_size) - eye_cell
    if num == 0:
        return 0, 0, 2 * _LENGTH, 0
    steps_per_unit = _LENGTH / (end - eye)
    border = (eye_cell + (num > 0)) * cell_size
    first = int(min((border - eye) * steps_per_unit, float(_LENGTH)))
    step = int(min(cell_size * abs(steps_per_unit), float(_LENGTH)))
    return abs(num), 1 if num > 0 else -1, first, step
