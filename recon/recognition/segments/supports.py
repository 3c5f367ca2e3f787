"""Supports: raised level boards that objects stand on, such as table tops."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_erosion

from recon.recognition.connectivity import linked
from recon.records import Voxels

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]

SHARE = 0.1
"""Minimum share of the standing cells on a support."""
OF_FLOOR = 0.04
"""Its minimum size relative to the floor: the top of a box on a table is smaller."""
LEAST_CELLS = 60
"""Minimum number of cells of a support: fewer are the top of an object."""
FILLED = 0.5
"""Minimum share of the columns of its box that a support fills."""
COVERED = 0.4
"""Maximum share of a support covered by the objects on it."""
OPEN = 0.2
"""Maximum share of a support's rim with cells below: a box has sides, a table has legs."""
LEAST_ON_IT = 12
"""Minimum number of cells above a support that show an object on it."""
HALF_CELLS, ABOVE_CELLS, BELOW_CELLS = 1.0, 1.5, 2.5
"""Half the thickness of a board, and minimum distances of what is on it and under it."""
LINK_CELLS = 2.5
MOST_SUPPORTS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """A level board and its legs."""

    height: float
    """Height in the level frame."""
    board: Rows
    """Its own cells."""
    legs: Rows
    """Cells connected to it from below."""
    columns: Mask
    """(X, Z) columns of cells that it covers ..."""
    corner: NDArray[np.int64]
    """(2,) ... and the index of the first."""

    def holds(self, cells: Voxels) -> Mask:
        """Mask (K,) of the cells above or below it."""
        return _at(self.columns, _columns(cells) - self.corner)


def find_supports(cells: Voxels, standing: Mask, num_floor: int) -> list[Support]:
    """The supports of a level map, in descending order of cells.

    A support is a filled, mostly bare level board with something on it and open space beneath.

    Parameters
    ----------
    cells : Voxels
        Means in the level frame, y up.
    standing : (K,) bool
        Cells above the floor and in front of the walls.
    num_floor : int
        Number of floor cells.
    """
    supports: list[Support] = []
    rest = np.flatnonzero(standing)
    least = max(LEAST_CELLS, SHARE * len(rest), OF_FLOOR * num_floor)
    heights = cells.means[:, 1]
    tried = np.zeros(len(cells), dtype=bool)
    for _ in range(MOST_SUPPORTS):
        rows = _fullest(heights, rest[~tried[rest]], HALF_CELLS * cells.cell_size)
        if len(rows) < least:
            break
        tried[rows] = True
        board = rows[_largest(cells.means[rows], LINK_CELLS * cells.cell_size)]
        support = _support(cells, rest, board) if len(board) >= least else None
        if support is not None:
            supports.append(support)
            rest = np.setdiff1d(rest, np.concatenate([support.board, support.legs]))
    return supports


def _fullest(heights: Array, rows: Rows, reach: float) -> Rows:
    """Rows of the level layer with the most cells, `reach` thick on either side."""
    own = np.sort(heights[rows])
    counts = np.searchsorted(own, own + 2.0 * reach, side="right") - np.arange(len(own))
    if not len(own):
        return rows
    middle = own[int(np.argmax(counts))] + reach
    layer: Rows = rows[np.abs(heights[rows] - middle) <= reach]
    return layer


def _largest(points: Array, reach: float) -> Mask:
    label = linked(points, reach)
    largest: Mask = label == np.argmax(np.bincount(label))
    return largest


def _support(cells: Voxels, rest: Rows, board: Rows) -> Support | None:
    """The board as a support; None if it is not one."""
    height = float(np.median(cells.means[board, 1]))
    columns = _columns(cells)
    corner = columns[board].min(axis=0)
    mask = np.zeros(columns[board].max(axis=0) - corner + 1, dtype=bool)
    mask[tuple((columns[board] - corner).T)] = True
    over = rest[_at(mask, columns[rest] - corner)]
    rise = (cells.means[over, 1] - height) / cells.cell_size
    above = over[rise > ABOVE_CELLS]
    covered = len(np.unique(columns[above], axis=0)) / mask.sum()
    if mask.mean() < FILLED or len(above) < LEAST_ON_IT or covered > COVERED:
        return None
    low = rest[cells.means[rest, 1] < height - BELOW_CELLS * cells.cell_size]
    if _closed(mask, columns[low] - corner) > OPEN:
        return None
    return Support(
        height=height,
        board=board,
        legs=_hanging(cells, _beneath(cells, rest, mask, corner, height), height),
        columns=mask,
        corner=corner,
    )


def _closed(mask: Mask, low: NDArray[np.int64]) -> float:
    """Share of the rim of a board with cells under or just beside it."""
    wide = np.pad(mask, 1)
    sides = np.zeros_like(wide)
    inside = ((low >= -1) & (low <= mask.shape)).all(axis=1)
    sides[tuple((low[inside] + 1).T)] = True
    rim = wide & ~binary_erosion(wide)
    return float(binary_dilation(sides)[rim].mean())


def _beneath(
    cells: Voxels, rest: Rows, mask: Mask, corner: NDArray[np.int64], height: float
) -> Rows:
    """Rows of the cells below a board, under it or just beside it."""
    wide = binary_dilation(np.pad(mask, 2), iterations=2)
    under = _at(wide, _columns(cells)[rest] - corner + 2)
    low = cells.means[rest, 1] < height - HALF_CELLS * cells.cell_size
    beneath: Rows = rest[under & low]
    return beneath


def _hanging(cells: Voxels, below: Rows, height: float) -> Rows:
    """The cells below a board that are connected up to it."""
    if not len(below):
        return below
    label = linked(cells.means[below], LINK_CELLS * cells.cell_size)
    tops = np.full(int(label.max()) + 1, -np.inf)
    np.maximum.at(tops, label, cells.means[below, 1])
    hanging: Rows = below[(tops > height - BELOW_CELLS * cells.cell_size)[label]]
    return hanging


def _columns(cells: Voxels) -> NDArray[np.int64]:
    """Column (K, 2) of each cell, seen from above."""
    columns: NDArray[np.int64] = np.floor(cells.means[:, ::2] / cells.cell_size).astype(np.int64)
    return columns


def _at(mask: Mask, index: NDArray[np.int64]) -> Mask:
    """Values (N,) of a mask at positions that may be outside it."""
    inside = ((index >= 0) & (index < mask.shape)).all(axis=1)
    found = np.zeros(len(index), dtype=bool)
    found[inside] = mask[tuple(index[inside].T)]
    return found
