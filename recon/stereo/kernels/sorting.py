"""Order and median of numbers, several times as fast as numpy's `argsort` and `median`."""

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.int64]

_ROW_BITS = 32


def order(keys: NDArray[np.integer]) -> Rows:
    """Rows sorted by their keys; equal ones keep their order.

    Parameters
    ----------
    keys : (N,) integers that fit into 32 bits
    """
    numbers = (keys.astype(np.int64) << _ROW_BITS) + np.arange(len(keys))
    numbers.sort()
    rows: Rows = numbers & ((1 << _ROW_BITS) - 1)
    return rows


def falling(values: NDArray[np.float32]) -> Rows:
    """Rows sorted by descending value; equal ones keep their order."""
    bits = (-values).view(np.int32)
    # Bits of negative numbers increase as the numbers decrease.
    return order(np.where(bits < 0, -(bits & np.int32(0x7FFFFFFF)), bits))


def median(values: NDArray[np.floating]) -> float:
    """The median of at least one finite number."""
    lower, upper = (len(values) - 1) // 2, len(values) // 2
    ordered = np.partition(values, (lower, upper))
    return float((ordered[lower] + ordered[upper]) / 2)
