"""Supports: level boards raised over the floor that things stand on, such as a table top."""

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
"""Share of the standing cells that a support must hold."""
OF_FLOOR = 0.04
"""Its size as a share of the floor's: the top of a box on a table is smaller."""
LEAST_CELLS = 60
"""Cells that a support needs: fewer are the top of a thing."""
FILLED = 0.5
"""Share of the columns of its box that a support must fill."""
COVERED = 0.4
"""Share of a support that the things on it may cover."""
OPEN = 0.2
"""Share of its rim under which a support may have cells: a box has sides, a table has legs."""
LEAST_ON_IT = 12
"""Cells over a support from which something stands on it."""
HALF_CELLS, ABOVE_CELLS, BELOW_CELLS = 1.0, 1.5, 2.5
"""Half the thickness of a board, and distances from it of what is on it and under it."""
LINK_CELLS = 2.5
MOST_SUPPORTS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Support:
    """A level board and what holds it."""

    height: float
    """Level frame."""
    board: Rows
    """Its own cells."""
    legs: Rows
    """Cells that hang under it."""
    columns: Mask
    """(X, Z) columns of cells that it lies in ..."""
    corner: NDArray[np.int64]
    """(2,) ... and the number of the first."""

    def holds(self, cells: Voxels) -> Mask:
        """(K,) which cells lie over or under it."""
        return _at(self.columns, _columns(cells) - self.corner)


def find_supports(cells: Voxels, standing: Mask, num_floor: int) -> list[Support]:
    """The supports of a level map, the fullest first.

    A support is a level board, filled and mostly bare, that something stands on, and open beneath.

    Parameters
    ----------
    cells : Voxels
        Means level, y up.
    standing : (K,) bool
        Cells over the floor and before the walls.
    num_floor : int
        Cells of the floor.
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
    """Rows of the level layer, so thick on either side, that holds most."""
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
    """The board as a support; None where it is not one."""
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
    """Share of the rim of a board under which, or just beside it, there are cells."""
    wide = np.pad(mask, 1)
    sides = np.zeros_like(wide)
    inside = ((low >= -1) & (low <= mask.shape)).all(axis=1)
    sides[tuple((low[inside] + 1).T)] = True
    rim = wide & ~binary_erosion(wide)
    return float(binary_dilation(sides)[rim].mean())


def _beneath(
    cells: Voxels, rest: Rows, mask: Mask, corner: NDArray[np.int64], height: float
) -> Rows:
    """Rows of the cells lower than a board, under it or just beside it."""
    wide = binary_dilation(np.pad(mask, 2), iterations=2)
    under = _at(wide, _columns(cells)[rest] - corner + 2)
    low = cells.means[rest, 1] < height - HALF_CELLS * cells.cell_size
    beneath: Rows = rest[under & low]
    return beneath


def _hanging(cells: Voxels, below: Rows, height: float) -> Rows:
    """Those of the cells below a board that hang together up to it."""
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
    """(N,) a mask at places that may lie outside of it."""
    inside = ((index >= 0) & (index < mask.shape)).all(axis=1)
    found = np.zeros(len(index), dtype=bool)
    found[inside] = mask[tuple(index[inside].T)]
    return found
