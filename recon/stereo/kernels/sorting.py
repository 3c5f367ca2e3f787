"""Stable orders by one sort of plain 64-bit numbers, several times as fast as an `argsort`."""

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.int64]

_ROW_BITS = 32


def order(keys: NDArray[np.integer]) -> Rows:
    """Rows by their keys, equal ones as they stand.

    Parameters
    ----------
    keys : (N,) integers that fit into 32 bits
    """
    numbers = (keys.astype(np.int64) << _ROW_BITS) + np.arange(len(keys))
    numbers.sort()
    rows: Rows = numbers & ((1 << _ROW_BITS) - 1)
    return rows


def falling(values: NDArray[np.float32]) -> Rows:
    """Rows by falling value, equal ones as they stand."""
    bits = (-values).view(np.int32)
    # Bits of negative numbers grow as the numbers fall.
    return order(np.where(bits < 0, -(bits & np.int32(0x7FFFFFFF)), bits))
