"""Sums of cells in index order, so that two maps are added in one pass over both.

Sums are integers, so the result does not depend on the order in which maps are added.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap import hits

Index = NDArray[np.int32]
Sums = Mapping[str, NDArray[np.uint64]]
Key = tuple[int, int, int]
"""Index of a cube of space along x, y, z."""

HITS = ("count", "position_x", "position_y", "position_z")
"""Names of the sums that every map has."""
COLOURS = ("colour_red", "colour_green", "colour_blue")
"""Names of the sums that follow them in a map with colours."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CellSums:
    """Sums of a map's cells, including the coarser ones."""

    index: Index
    """(4, K) level, x, y, z; a cell of level k is 2^k times as large. Sorted, unique."""
    names: tuple[str, ...]
    """(S,) names of the sums."""
    values: NDArray[np.uint64]
    """(S, K) sums over the points of a cell."""
    views: Index
    """(4, P) x, y, z of a cell of level 0, and a view that saw it; sorted, unique."""

    def __len__(self) -> int:
        return int(self.index.shape[1])

    @property
    def has_colour(self) -> bool:
        """True if the colours are known."""
        return COLOURS[0] in self.names

    @property
    def sums(self) -> Sums:
        """The sums (K,) by name."""
        return dict(zip(self.names, self.values, strict=True))

    def __add__(self, other: "CellSums") -> "CellSums":
        """The union of both; the sums of common cells are added."""
        index, values = _united(self.index, other.index, self.values, other.values)
        nothing = np.zeros((0, 0), np.uint64)
        views, _ = _united(self.views, other.views, nothing, nothing)
        total = CellSums(index=index, names=self.names, values=values, views=views)
        if total.sums["count"].max(initial=0) > hits.CAPACITY[hits.WIDE]:
            raise InputError(f"a cell contains more than {hits.CAPACITY[hits.WIDE]} points")
        return total

    def without_colour(self) -> "CellSums":
        """The same cells without their colours."""
        kept = [row for row, name in enumerate(self.names) if name not in COLOURS]
        names = tuple(self.names[row] for row in kept)
        return replace(self, names=names, values=self.values[kept])

    def select(self, rows: NDArray[np.integer] | slice, views: NDArray[np.integer]) -> "CellSums":
        """Some of the cells and of the views, in their original order."""
        return CellSums(
            index=np.ascontiguousarray(self.index[:, rows]),
            names=self.names,
            values=np.ascontiguousarray(self.values[:, rows]),
            views=np.ascontiguousarray(self.views[:, views]),
        )


def added(parts: Iterable[CellSums]) -> CellSums:
    """The sum of one or more parts, added as a tree of pairs of similar size."""
    waiting: list[tuple[int, CellSums]] = []
    for part in parts:
        rank, total = 0, part
        while waiting and waiting[-1][0] == rank:
            total = waiting.pop()[1] + total
            rank += 1
        waiting.append((rank, total))
    return reduce(lambda total, part: part + total, [one for _, one in reversed(waiting)])


def split(cells: CellSums, side: int) -> Iterator[tuple[Key, CellSums]]:
    """The cells of every cube of `side` level-0 cells, in cube order.

    `side` is a multiple of the coarsest cell, so that every cell lies in one cube.
    """
    level, places = cells.index[0], cells.index[1:].astype(np.int64)
    of_cells = _groups((places << level) // side)
    of_views = _groups(cells.views[:3].astype(np.int64) // side)
    nothing = np.zeros(0, np.int64)
    for key in sorted(of_cells):
        yield key, cells.select(of_cells[key], of_views.get(key, nothing))


def _groups(cubes: NDArray[np.int64]) -> dict[Key, NDArray[np.int64]]:
    """Columns of (3, K) grouped by content, each group in its original order.

    Neighbours are mostly equal, so runs of equal columns are sorted.
    """
    if not cubes.shape[1]:
        return {}
    starts = _starts(cubes)
    runs = np.lexsort(cubes[::-1, starts])
    ordered, lengths = cubes[:, starts[runs]], np.diff(starts, append=cubes.shape[1])[runs]
    ends = np.cumsum(lengths)
    rows = np.repeat(starts[runs] - ends + lengths, lengths) + np.arange(cubes.shape[1])
    groups = _starts(ordered)
    first_rows = (ends - lengths)[groups]
    keys = ordered[:, groups].T.tolist()
    parts = np.split(rows, first_rows[1:])
    return {(x, y, z): own for (x, y, z), own in zip(keys, parts, strict=True)}


def _starts(columns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices of the columns that differ from the previous one."""
    begins = np.ones(columns.shape[1], np.bool_)
    begins[1:] = (columns[:, 1:] != columns[:, :-1]).any(axis=0)
    return np.flatnonzero(begins)


def is_ordered(index: Index) -> bool:
    """True if the columns of (4, K) are strictly increasing."""
    return bool(_rises(np.ascontiguousarray(index)))


def lie_in(index: Index, cube: Key, side: int) -> bool:
    """True if all cells (4, K) are in one cube of `side` level-0 cells."""
    return bool(_lie_in(np.ascontiguousarray(index), cube, side))


def at_most(values: NDArray[np.uint64], counts: NDArray[np.uint64], each: int) -> bool:
    """True if no sum (K,) exceeds `counts` points times `each`."""
    return bool(_at_most(values, counts, np.uint64(each)))


def _united(
    a: Index, b: Index, values_a: NDArray[np.uint64], values_b: NDArray[np.uint64]
) -> tuple[Index, NDArray[np.uint64]]:
    """The union of the columns of both indices, and their sums."""
    if not a.shape[1] or not b.shape[1]:
        return (a, values_a) if a.shape[1] else (b, values_b)
    most = a.shape[1] + b.shape[1]
    index, owners = np.empty((4, most), np.int32), np.empty(most, np.uint8)
    stop_a, stop_b, num = _unite(a, b, index, owners)
    rest = num + a.shape[1] - stop_a
    index = np.hstack([index[:, :num], a[:, stop_a:], b[:, stop_b:]])
    values = np.empty((len(values_a), index.shape[1]), np.uint64)
    for row, total in enumerate(values):
        _add(values_a[row], values_b[row], owners[:num], total)
        total[num:rest], total[rest:] = values_a[row, stop_a:], values_b[row, stop_b:]
    return index, values


@njit(cache=True, nogil=True, inline="always")
def _order(a: Index, i: int, b: Index, j: int) -> tuple[bool, bool]:
    """Flags: column i of `a` is before column j of `b`; they are equal.

    Without branches: which of two maps has the next cell cannot be predicted.
    """
    high_a, high_b = np.int64(a[0, i]) << 32, np.int64(b[0, j]) << 32
    high_a, high_b = high_a + a[1, i], high_b + b[1, j]
    low_a, low_b = np.int64(a[2, i]) << 32, np.int64(b[2, j]) << 32
    low_a, low_b = low_a + a[3, i], low_b + b[3, j]
    same_high = high_a == high_b
    return (high_a < high_b) | (same_high & (low_a < low_b)), same_high & (low_a == low_b)


@njit(cache=True, nogil=True)
def _unite(a: Index, b: Index, index: Index, owners: NDArray[np.uint8]) -> tuple[int, int, int]:
    """Fill in the union until one index ends; owners are 1 for `a`, 2 for `b`, 3 for both.

    Returns
    -------
    stop_a, stop_b, num
        Columns taken from either, and columns filled in.
    """
    i = j = num = 0
    while i < a.shape[1] and j < b.shape[1]:
        is_before, is_same = _order(a, i, b, j)
        in_a, in_b = is_before | is_same, not is_before
        for row in range(4):
            index[row, num] = a[row, i] if in_a else b[row, j]
        owners[num] = np.uint8(in_a) + 2 * np.uint8(in_b)
        i += in_a
        j += in_b
        num += 1
    return i, j, num


@njit(cache=True, nogil=True)
def _add(
    a: NDArray[np.uint64],
    b: NDArray[np.uint64],
    owners: NDArray[np.uint8],
    total: NDArray[np.uint64],
) -> None:
    """Fill in the values of a column's only owner, or the sums of both."""
    i = j = np.uint64(0)
    for n in range(len(owners)):
        in_a, in_b = np.uint64(owners[n] & 1), np.uint64(owners[n] >> 1)
        total[n] = a[i] * in_a + b[j] * in_b
        i += in_a
        j += in_b


@njit(cache=True, nogil=True)
def _rises(index: Index) -> bool:
    num_falls = 0
    for n in range(1, index.shape[1]):
        num_falls += not _order(index, n - 1, index, n)[0]
    return num_falls == 0


@njit(cache=True, nogil=True)
def _lie_in(index: Index, cube: Key, side: int) -> bool:
    """A corner of a coarse cell suffices, since no cell is in two cubes."""
    num_outside = 0
    for axis in range(3):
        low = cube[axis] * side
        for n in range(index.shape[1]):
            place = np.int64(index[axis + 1, n]) << index[0, n]
            num_outside += place < low or place >= low + side
    return num_outside == 0


@njit(cache=True, nogil=True)
def _at_most(values: NDArray[np.uint64], counts: NDArray[np.uint64], each: np.uint64) -> bool:
    num_above = 0
    for n in range(len(values)):
        num_above += values[n] > counts[n] * each
    return num_above == 0
