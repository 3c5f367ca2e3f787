"""A hash table of cells: rows in the order of arrival, found by their index along x, y, z.

A row is one structured element, so that a point touches one or two cache lines. The slots hold
(hash << 32 | row + 1), 0 = empty, placed by the hash's share of their number: a larger table has
them in the same order, so growing reads and writes straight through memory.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Rows = NDArray[np.void]
Slots = NDArray[np.uint64]

MAX_INDEX = 2**31 - 1
"""Largest number of a cell along an axis, on either side of 0."""

# At 0.7 a search in linear order looks at two slots; 1.25 keeps the unused end of the rows short.
_MAX_LOAD = 0.7
_GROWTH = 1.25
_FIRST_ROWS = 64

# Odd 64-bit constants of the xxHash family: each spreads its factor over the upper bits.
_SPREAD_X = np.uint64(0x9E3779B97F4A7C15)
_SPREAD_Y = np.uint64(0xC2B2AE3D27D4EB4F)
_SPREAD_Z = np.uint64(0x165667B19E3779F9)
_SPREAD_ALL = np.uint64(0xD6E8FEB86659FD93)
_HALF = np.uint64(32)
_LOWER = np.uint64(0xFFFFFFFF)
_EMPTY = np.uint64(0)
_ONE = np.uint64(1)


@njit(cache=True)
def _hash(x: int, y: int, z: int) -> np.uint64:
    """32 well-mixed bits of a cell's index."""
    mixed = (
        np.uint64(np.uint32(x)) * _SPREAD_X
        ^ np.uint64(np.uint32(y)) * _SPREAD_Y
        ^ np.uint64(np.uint32(z)) * _SPREAD_Z
    )
    mixed ^= mixed >> _HALF
    mixed *= _SPREAD_ALL
    return mixed >> _HALF


@njit(cache=True)
def _next(slot: np.uint64, size: np.uint64) -> np.uint64:
    following = slot + _ONE
    return following if following < size else _EMPTY


@njit(cache=True)
def find_or_add(
    slots: Slots, rows: Rows, num_rows: int, index: tuple[int, int, int]
) -> tuple[int, int]:
    """The row of a cell, and the number of rows: one more where the cell is new.

    There must be room for a new row: `num_rows < len(rows)`.
    """
    x, y, z = index
    fingerprint = _hash(x, y, z)
    size = np.uint64(slots.size)
    slot = (fingerprint * size) >> _HALF
    while slots[slot] != _EMPTY:
        if slots[slot] >> _HALF == fingerprint:
            row = int(slots[slot] & _LOWER) - 1
            key = rows[row].index
            if key[0] == x and key[1] == y and key[2] == z:
                return row, num_rows
        slot = _next(slot, size)
    slots[slot] = (fingerprint << _HALF) | np.uint64(num_rows + 1)
    key = rows[num_rows].index
    key[0], key[1], key[2] = x, y, z
    return num_rows, num_rows + 1


@njit(cache=True)
def _refill(slots: Slots, larger: Slots) -> None:
    size = np.uint64(larger.size)
    for entry in slots:
        if entry == _EMPTY:
            continue
        slot = ((entry >> _HALF) * size) >> _HALF
        while larger[slot] != _EMPTY:
            slot = _next(slot, size)
        larger[slot] = entry


class CellTable:
    """Rows of one structured type, whose field `index` (3,) int32 names the cell."""

    def __init__(self, dtype: np.dtype[np.void], num_rows: int = _FIRST_ROWS) -> None:
        self.rows: Rows = np.zeros(max(num_rows, _FIRST_ROWS), dtype)
        self.slots: Slots = np.zeros(int(len(self.rows) / _MAX_LOAD) + 1, np.uint64)
        self.num_rows = 0

    @property
    def is_full(self) -> bool:
        """Whether there is no room for another cell."""
        return self.num_rows == len(self.rows)

    @property
    def nbytes(self) -> int:
        """Memory held."""
        return int(self.rows.nbytes + self.slots.nbytes)

    @property
    def arrays(self) -> tuple[Slots, Rows, int]:
        """What the compiled loops work on."""
        return self.slots, self.rows, self.num_rows

    @property
    def used(self) -> Rows:
        """The rows that name a cell, in the order of arrival (a view)."""
        return self.rows[: self.num_rows]

    def grow(self) -> None:
        """Make room for a quarter more cells."""
        # resize() may move the block without a copy; nobody else holds the array.
        self.rows.resize(int(len(self.rows) * _GROWTH), refcheck=False)
        if len(self.rows) > _MAX_LOAD * len(self.slots):
            larger = np.zeros(int(len(self.rows) * _GROWTH / _MAX_LOAD), np.uint64)
            _refill(self.slots, larger)
            self.slots = larger

    def widen(self, dtype: np.dtype[np.void]) -> None:
        """Give the fields of the rows the wider types of `dtype`."""
        self.rows = self.rows.astype(dtype)
