"""Sums of cells in index order, so that two maps are added in one pass over both.

Sums are integers, so the result does not depend on the order in which maps are added.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
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

HITS = (
    "count", "position_x", "position_y", "position_z", "colour_red", "colour_green", "colour_blue",
)  # fmt: skip
"""Names of the sums that every map has."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CellSums:
    """Sums of a map's cells, including the coarser ones."""

    index: Index
    """(4, K) level, x, y, z; a cell of level k is 2^k times as large. Sorted, unique."""
    sums: Sums
    """(K,) each, by name: sums over the points of a cell."""
    views: Index
    """(4, P) x, y, z of a cell of level 0, and a view that saw it; sorted, unique."""

    def __len__(self) -> int:
        return int(self.index.shape[1])

    def __add__(self, other: "CellSums") -> "CellSums":
        """The union of both; the sums of common cells are added."""
        index, sums = _united(self.index, other.index, self.sums, other.sums)
        views, _ = _united(self.views, other.views, {}, {})
        if len(sums["count"]) and sums["count"].max() > hits.CAPACITY[hits.WIDE]:
            raise InputError(f"a cell contains more than {hits.CAPACITY[hits.WIDE]} points")
        return CellSums(index=index, sums=sums, views=views)

    def select(self, rows: NDArray[np.integer] | slice, views: NDArray[np.integer]) -> "CellSums":
        """Some of the cells and of the views, in their original order."""
        return CellSums(
            index=np.ascontiguousarray(self.index[:, rows]),
            sums={name: values[rows] for name, values in self.sums.items()},
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
    """Columns of (3, K) grouped by content, each group in its original order."""
    if not cubes.shape[1]:
        return {}
    order = np.lexsort(cubes[::-1])
    ordered = cubes[:, order]
    starts = np.flatnonzero((np.diff(ordered, axis=1) != 0).any(axis=0)) + 1
    keys = ordered[:, np.concatenate([[0], starts])].T.tolist()
    return {(x, y, z): rows for (x, y, z), rows in zip(keys, np.split(order, starts), strict=True)}


def is_ordered(index: Index) -> bool:
    """True if the columns of (4, K) are strictly increasing."""
    return bool(_rises(np.ascontiguousarray(index)))


def _united(a: Index, b: Index, sums_a: Sums, sums_b: Sums) -> tuple[Index, Sums]:
    """The union of the columns of both indices, and their sums."""
    if not a.shape[1] or not b.shape[1]:
        return (a, sums_a) if a.shape[1] else (b, sums_b)
    place_a, place_b = np.empty(a.shape[1], np.int64), np.empty(b.shape[1], np.int64)
    num: int = _interleave(a, b, place_a, place_b)
    index = np.empty((4, num), np.int32)
    _put(a, place_a, index)
    _put(b, place_b, index)
    sums = {}
    for name, values in sums_a.items():
        sums[name] = np.zeros(num, np.uint64)
        _add(values, place_a, sums[name])
        _add(sums_b[name], place_b, sums[name])
    return index, sums


@njit(cache=True)
def _compare(a: Index, i: int, b: Index, j: int) -> int:
    """Negative, 0 or positive if column i of `a` is before, equal to or after column j of `b`."""
    for row in range(4):
        if a[row, i] != b[row, j]:
            return -1 if a[row, i] < b[row, j] else 1
    return 0


@njit(cache=True)
def _interleave(a: Index, b: Index, place_a: NDArray[np.int64], place_b: NDArray[np.int64]) -> int:
    """Fill in the position of each column in the union; return the size of the union."""
    i = j = num = 0
    while i < a.shape[1] and j < b.shape[1]:
        order = _compare(a, i, b, j)
        place_a[i] = place_b[j] = num
        i += order <= 0
        j += order >= 0
        num += 1
    for rest in range(i, a.shape[1]):
        place_a[rest] = num + rest - i
    for rest in range(j, b.shape[1]):
        place_b[rest] = num + rest - j
    return int(num + a.shape[1] - i + b.shape[1] - j)


@njit(cache=True)
def _put(columns: Index, place: NDArray[np.int64], index: Index) -> None:
    for row in range(4):
        for n in range(len(place)):
            index[row, place[n]] = columns[row, n]


@njit(cache=True)
def _add(values: NDArray[np.uint64], place: NDArray[np.int64], total: NDArray[np.uint64]) -> None:
    for n in range(len(values)):
        total[place[n]] += values[n]


@njit(cache=True)
def _rises(index: Index) -> bool:
    num_falls = 0
    for n in range(1, index.shape[1]):
        num_falls += _compare(index, n - 1, index, n) >= 0
    return num_falls == 0
