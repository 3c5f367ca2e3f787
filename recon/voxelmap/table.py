"""A hash table of cells: rows in order of insertion, found by their index along x, y, z.

A row is one structured element, so that a point touches one or two cache lines. A slot holds a row
number + 1, 0 = empty; linear probing starts at the slot given by the hash.
"""

from collections.abc import Callable
from typing import Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

Rows = NDArray[np.void]
Slots = NDArray[np.uint32]
Choose = Callable[[NDArray[np.integer]], NDArray[np.bool_]]
"""A mask (K,) of cells by their indices (K, 3)."""

MAX_INDEX = 2**31 - 1
"""Largest cell index along an axis, on either side of 0."""

# The load is low since a slot costs 4 bytes but a wrong row a cache line; a growth of 1.25 keeps
# the unused end of the rows short.
_MAX_LOAD = 0.35
_GROWTH = 1.25
_FIRST_ROWS = 64

# Odd 64-bit constants of the xxHash family: each spreads its factor over the upper bits.
_SPREAD_X = np.uint64(0x9E3779B97F4A7C15)
_SPREAD_Y = np.uint64(0xC2B2AE3D27D4EB4F)
_SPREAD_Z = np.uint64(0x165667B19E3779F9)
_SPREAD_ALL = np.uint64(0xD6E8FEB86659FD93)
_HALF = np.uint64(32)


@njit(cache=True)
def _home(slots: Slots, index: tuple[int, int, int]) -> np.int64:
    """Slot at which the search for a cell starts."""
    mixed = (
        np.uint64(np.uint32(index[0])) * _SPREAD_X
        ^ np.uint64(np.uint32(index[1])) * _SPREAD_Y
        ^ np.uint64(np.uint32(index[2])) * _SPREAD_Z
    )
    mixed = (mixed ^ (mixed >> _HALF)) * _SPREAD_ALL
    return np.int64(((mixed >> _HALF) * np.uint64(slots.size)) >> _HALF)


@njit(cache=True)
def _search(slots: Slots, rows: Rows, index: tuple[int, int, int]) -> np.int64:
    """The slot of a cell, or the empty one where it would be."""
    slot = _home(slots, index)
    while slots[slot] != 0 and not _is_at(rows, np.int64(slots[slot]) - 1, index):
        slot += 1
        if slot == slots.size:
            slot = np.int64(0)
    return slot  # type: ignore[no-any-return]


@njit(cache=True)
def _is_at(rows: Rows, row: int, index: tuple[int, int, int]) -> bool:
    key = rows[row].index
    return bool(key[0] == index[0] and key[1] == index[1] and key[2] == index[2])


@njit(cache=True)
def find_or_add(
    slots: Slots, rows: Rows, num_rows: int, index: tuple[int, int, int]
) -> tuple[np.int64, np.int64]:
    """The row of a cell, and the number of rows, which grows by one if the cell is new.

    There must be room for a new row: `num_rows < len(rows)`.
    """
    slot = _search(slots, rows, index)
    if slots[slot] != 0:
        return np.int64(slots[slot]) - 1, np.int64(num_rows)
    slots[slot] = num_rows + 1
    key = rows[num_rows].index
    key[0], key[1], key[2] = index
    return np.int64(num_rows), np.int64(num_rows) + 1


@njit(cache=True)
def find_row(slots: Slots, rows: Rows, index: tuple[int, int, int]) -> int:
    """The row of a cell, -1 if missing."""
    return int(slots[_search(slots, rows, index)]) - 1


@njit(cache=True)
def _lookup(slots: Slots, rows: Rows, index: NDArray[np.int32]) -> NDArray[np.int64]:
    """The row of each cell (K, 3), -1 if missing."""
    found = np.empty(len(index), np.int64)
    for k in range(len(index)):
        found[k] = find_row(slots, rows, (index[k, 0], index[k, 1], index[k, 2]))
    return found


@njit(cache=True)
def _enter(
    slots: Slots,
    rows: Rows,
    num_rows: int,
    index: NDArray[np.int32],
    found: NDArray[np.int64],
    first: int,
) -> tuple[int, np.int64]:
    """Find or add cells (K, 3) until the table is full; return the next cell and the row count."""
    num = np.int64(num_rows)
    for k in range(first, len(index)):
        if num == len(rows):
            return k, num
        found[k], num = find_or_add(slots, rows, num, (index[k, 0], index[k, 1], index[k, 2]))
    return len(index), num


@njit(cache=True)
def _refill(slots: Slots, rows: Rows, num_rows: int) -> None:
    """Enter all rows, which are distinct cells, into empty slots."""
    for row in range(num_rows):
        key = rows[row].index
        slots[_search(slots, rows, (key[0], key[1], key[2]))] = row + 1


class CellTable:
    """Rows of one structured type, whose field `index` (3,) int32 identifies the cell."""

    def __init__(self, dtype: np.dtype[np.void], num_rows: int = _FIRST_ROWS) -> None:
        self.rows: Rows = np.zeros(max(num_rows, _FIRST_ROWS), dtype)
        self.slots: Slots = np.zeros(int(len(self.rows) / _MAX_LOAD) + 1, np.uint32)
        self.num_rows = 0

    @classmethod
    def of(cls, rows: Rows) -> Self:
        """A table with rows of distinct cells, in their order."""
        table = cls(rows.dtype, len(rows) + 1)
        table.rows[: len(rows)] = rows
        table.num_rows = len(rows)
        _refill(*table.arrays)
        return table

    def __reduce__(self) -> tuple[Callable[[Rows], Self], tuple[Rows]]:
        """Pickle only the used rows: less data, and the unpickled arrays can grow."""
        return type(self).of, (self.used.copy(),)

    def find(self, index: NDArray[np.integer]) -> NDArray[np.int64]:
        """The row of each cell (K, 3), -1 if missing."""
        cells = np.ascontiguousarray(index, np.int32)
        rows: NDArray[np.int64] = _lookup(self.slots, self.rows, cells)
        return rows

    def enter(self, index: NDArray[np.integer]) -> NDArray[np.int64]:
        """The row of each cell (K, 3), added if new."""
        cells, done = np.ascontiguousarray(index, np.int32), 0
        rows = np.empty(len(cells), np.int64)
        while done < len(cells):
            done, num = _enter(*self.arrays, cells, rows, done)
            self.num_rows = int(num)
            if self.is_full:
                self.grow()
        return rows

    @property
    def is_full(self) -> bool:
        """True if there is no room for another cell."""
        return self.num_rows == len(self.rows)

    @property
    def nbytes(self) -> int:
        """Memory used."""
        return int(self.rows.nbytes + self.slots.nbytes)

    @property
    def arrays(self) -> tuple[Slots, Rows, int]:
        """Slots, rows and their number, for the compiled loops."""
        return self.slots, self.rows, self.num_rows

    @property
    def used(self) -> Rows:
        """The rows in use, in order of insertion (a view)."""
        return self.rows[: self.num_rows]

    def grow(self) -> None:
        """Make room for a quarter more cells."""
        # resize() may move the block without a copy; no other reference to the array exists.
        self.rows.resize(int(len(self.rows) * _GROWTH), refcheck=False)
        if len(self.rows) > _MAX_LOAD * len(self.slots):
            self.slots = np.zeros(int(len(self.rows) * _GROWTH / _MAX_LOAD), np.uint32)
            _refill(*self.arrays)

    def widen(self, dtype: np.dtype[np.void]) -> None:
        """Give the fields of the rows the wider types of `dtype`."""
        self.rows = self.rows.astype(dtype)


def order_of(index: NDArray[np.integer]) -> NDArray[np.int64]:
    """The rows (K,) of cells (K, 3) sorted by x, then y, then z."""
    x, y, z = index.T
    return np.lexsort((z, y, x))


def in_order(rows: Rows) -> Rows:
    """Rows sorted by their index."""
    return rows[order_of(rows["index"])]
