"""The depths that a camera saw, found by image point, to be compared with those of another."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.sorting import order

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Integers = NDArray[np.int64]

NUM_SIGMAS = 3.0
"""Maximum difference of two depths that agree, in standard deviations."""
MAX_OFFSET_PX = 3.0
"""Distance below which image points are compared: features slide along edges."""
NUM_CANDIDATES = 4
"""Number of nearest points within the offset whose depth is compared."""


class SeenDepths:
    """Points of an image, sorted into square blocks.

    Parameters
    ----------
    at_px : (N, 2) float64
        Image points; those outside the image lie in its outermost blocks.
    depth, sigma : (N,) float64
        Their depths and the standard deviations.
    size : (width, height)
        Of the image, pixels.
    """

    def __init__(self, at_px: Array, depth: Array, sigma: Array, size: tuple[int, int]) -> None:
        self._num_blocks = tuple(int(side / MAX_OFFSET_PX) + 1 for side in size)
        columns, rows = self._num_blocks
        block = _blocks(at_px, (columns, rows))
        self._starts = np.zeros(columns * rows + 1, np.int64)
        np.cumsum(np.bincount(block, minlength=columns * rows), out=self._starts[1:])
        self._seen = np.column_stack([at_px, depth, sigma])[order(block)]

    def agree(self, at_px: Array, depth: Array, sigma: Array) -> Mask:
        """Mask (M,) of given points whose depth is that of one of the nearest points."""
        given = np.column_stack([at_px, depth, sigma])
        return _agree(self._seen, self._starts, self._num_blocks, given)  # type: ignore[no-any-return]


@njit(cache=True, nogil=True, error_model="numpy")
def _blocks(at_px: Array, num_blocks: tuple[int, int]) -> Integers:
    """Number (N,) of the block of each image point."""
    columns, rows = num_blocks
    blocks = np.empty(len(at_px), np.int64)
    for k in range(len(at_px)):
        blocks[k] = _block(at_px[k, 1], rows) * columns + _block(at_px[k, 0], columns)
    return blocks


@njit(cache=True, nogil=True, error_model="numpy")
def _agree(seen: Array, starts: Integers, num_blocks: tuple[int, int], given: Array) -> Mask:
    found = np.zeros(len(given), np.bool_)
    nearest, row_of = np.empty(NUM_CANDIDATES), np.empty(NUM_CANDIDATES, np.int64)
    for k in range(len(given)):
        number = _find_nearest(seen, starts, num_blocks, given[k], (nearest, row_of))
        for i in row_of[:number]:
            limit = NUM_SIGMAS * np.hypot(seen[i, 3], given[k, 3])
            if abs(seen[i, 2] - given[k, 2]) <= limit:
                found[k] = True
                break
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _find_nearest(
    seen: Array,
    starts: Integers,
    num_blocks: tuple[int, int],
    point: Array,
    best: tuple[Array, Integers],
) -> int:
    """Write squared distance and row of the nearest points, and return their number."""
    nearest, row_of = best
    columns, rows = num_blocks
    nearest[:] = MAX_OFFSET_PX**2
    number = 0
    column, row = _block(point[0], columns), _block(point[1], rows)
    for line in range(max(row - 1, 0), min(row + 2, rows)):
        first, last = line * columns + max(column - 1, 0), line * columns + min(column + 2, columns)
        for i in range(starts[first], starts[last]):
            distance = (seen[i, 0] - point[0]) ** 2 + (seen[i, 1] - point[1]) ** 2
            if distance < nearest[-1]:
                number = min(number + 1, NUM_CANDIDATES)
                _take(nearest, row_of, distance, i)
    return number


@njit(cache=True, nogil=True, error_model="numpy")
def _block(place_px: float, num_blocks: int) -> int:
    """Block of a coordinate, which may lie outside the image."""
    if not place_px > 0.0:
        return 0
    return int(min(place_px / MAX_OFFSET_PX, num_blocks - 1.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _take(nearest: Array, row_of: Integers, distance: float, row: int) -> None:
    """Insert a point into the nearest ones, which are sorted."""
    k = len(nearest) - 1
    while k > 0 and nearest[k - 1] > distance:
        nearest[k], row_of[k] = nearest[k - 1], row_of[k - 1]
        k -= 1
    nearest[k], row_of[k] = distance, row
