"""The disparity of lowest cost at every pixel, confirmed by the right image."""

from typing import NamedTuple

import numpy as np
from numba import njit

from recon.stereo.dense.cost import UNIT
from recon.stereo.kernels.shorts import ShortArray
from recon.stereo.kernels.simd import Floats, Integers, kernel

NUM_PATHS = 8
_UNLOCKING = np.float32(2.3)
"""Exponent of the sub-pixel interpolation: differences of truncated levels form corners, not
parabolas, which corresponds to 1; but the small-step penalty pulls towards whole pixels."""
_TOLERANCE_PX = 1
"""Maximum difference of left and right choice."""
_PER_PATH = np.float32(1.0 / (UNIT * NUM_PATHS))


class Choice(NamedTuple):
    """The chosen disparity and its confidence; NaN where the right image does not confirm it."""

    disparity_px: Floats
    """(H, W) with sub-pixel precision."""
    steepness: Floats
    """(H, W) additional cost of the neighbouring disparities, in grey levels."""
    lead: Floats
    """(H, W) additional cost of the best disparity farther off, in grey levels."""
    cost: Floats
    """(H, W) cost of the pixel itself, in grey levels."""


def choose(cost: ShortArray, total: ShortArray, first: int, count: int) -> Choice:
    """The best disparity of every pixel.

    Parameters
    ----------
    cost, total : (H, W, D) int16
        Cost of the pixel itself, and summed over the paths.
    first, count : int
        The searched disparities.
    """
    choice = Choice(*(np.full(cost.shape[:2], np.nan, np.float32) for _ in Choice._fields))
    _choose(cost, total, first, count, choice)
    return choice


@njit(cache=True, nogil=True, error_model="numpy")
def _choose(cost: ShortArray, total: ShortArray, first: int, count: int, choice: Choice) -> None:
    height, width, _ = cost.shape
    best, best_right = np.empty(width, np.int64), np.empty(width, np.int64)
    lowest_right = np.empty(width, np.int64)
    for v in range(height):
        lowest_right[:] = 1 << 30
        best_right[:] = -(1 << 30)
        for u in range(width):
            best[u] = _lowest(total[v, u], u - first, count, lowest_right, best_right)
        for u in range(width):
            u_right = u - first - best[u]
            if 0 <= u_right < width and abs(best_right[u_right] - best[u]) <= _TOLERANCE_PX:
                _measure(v, u, cost[v, u], total[v, u, :count], best[u], choice)
                choice.disparity_px[v, u] += first


@kernel
def _lowest(
    total: ShortArray, column: int, count: int, lowest_right: Integers, best_right: Integers
) -> int:
    """Index of the lowest cost of a left pixel; updates the best ones of the right pixels, too."""
    width = lowest_right.size
    best, lowest = 0, np.int64(total[0])
    for d in range(count):
        value = np.int64(total[d])
        if value < lowest:
            best, lowest = d, value
        u_right = column - d
        if 0 <= u_right < width and value < lowest_right[u_right]:
            lowest_right[u_right], best_right[u_right] = value, d
    return best


@kernel
def _measure(
    v: int, u: int, cost: ShortArray, total: ShortArray, best: int, choice: Choice
) -> None:
    here = np.float32(total[best])
    second = np.float32(32767)
    for d in range(total.size):
        if abs(d - best) > 1:
            second = min(second, np.float32(total[d]))
    offset, steepness = np.float32(0), np.float32(0)
    if 0 < best < total.size - 1:
        before, behind = np.float32(total[best - 1]) - here, np.float32(total[best + 1]) - here
        steepness = max(before, behind)
        ratio = max(min(before, behind), np.float32(0)) / max(steepness, np.float32(1))
        half = np.float32(0.5) * (1 - ratio**_UNLOCKING)
        offset = half if before > behind else -half
    choice.disparity_px[v, u] = best + offset
    choice.steepness[v, u] = steepness * _PER_PATH
    choice.lead[v, u] = (second - here) * _PER_PATH
    choice.cost[v, u] = np.float32(cost[best]) * np.float32(1.0 / UNIT)
