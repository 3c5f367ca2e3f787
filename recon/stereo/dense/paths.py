"""Semi-global aggregation: the cost of the best path to each pixel along eight directions.

Hirschmueller's method (2008): along each direction a step of one disparity costs `small_step`, a
larger one `large_step`, which is lower where the grey level changes, since surfaces end there.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.shorts import (
    NUM_SHORTS,
    ShortArray,
    Shorts,
    least,
    lesser,
    load_shorts,
    spread_short,
    store_shorts,
)
from recon.stereo.kernels.simd import kernel

_EDGE = np.int16(8192)
"""Cost of the disparities beyond both ends of the search: they never win."""
_RIM = NUM_SHORTS
"""Padding before the first and after the last disparity of a row of the paths."""


class Penalties(NamedTuple):
    """Penalties for changes of disparity, in the unit of the costs."""

    small_step: int
    """For a change of one between neighbouring pixels."""
    large_step: ShortArray
    """(256,) for larger changes, by the difference of the grey levels."""


def aggregate(cost: ShortArray, grey: NDArray[np.uint8], penalties: Penalties) -> ShortArray:
    """Sum of the costs of the best paths to each pixel from eight directions.

    Parameters
    ----------
    cost : (H, W, D) int16
        D a multiple of `NUM_SHORTS`.
    grey : (H, W) uint8
    penalties : Penalties

    Returns
    -------
    total : (H, W, D) int16
    """
    total = np.empty_like(cost)
    _sweep(cost, grey, penalties, total, False)
    _sweep(cost, grey, penalties, total, True)
    return total


class _Ends(NamedTuple):
    """The current ends of paths in four directions: along the row, and from the previous row."""

    costs: ShortArray
    """(4, W + 2, D + 2 * _RIM) of every disparity; the first and last column lie outside."""
    lowest: ShortArray
    """(4, W + 2) minimum of these costs."""


@njit(cache=True, nogil=True)
def _sweep(
    cost: ShortArray, grey: NDArray[np.uint8], penalties: Penalties, total: ShortArray, back: bool
) -> None:
    """Add four directions in one sweep: along the row, and from three pixels of the previous one.

    Backwards, the sweep goes from the last pixel to the first.
    """
    height, width, depth = cost.shape
    costs = np.full((2, 4, width + 2, depth + 2 * _RIM), _EDGE, np.int16)
    # Paths start outside the image at cost 0.
    costs[:, :, :, _RIM:-_RIM] = 0
    lowest = np.zeros((2, 4, width + 2), np.int16)
    step = -1 if back else 1
    for row in range(height):
        v = height - 1 - row if back else row
        now = _Ends(costs[row % 2], lowest[row % 2])
        before = _Ends(costs[1 - row % 2], lowest[1 - row % 2])
        above = v - step if row else v
        for column in range(width):
            u = width - 1 - column if back else column
            behind, ahead = (u - step if column else u), min(max(u + step, 0), width - 1)
            jumps = (
                _jump(grey[v, u], grey[v, behind], penalties),
                _jump(grey[v, u], grey[above, behind], penalties),
                _jump(grey[v, u], grey[above, u], penalties),
                _jump(grey[v, u], grey[above, ahead], penalties),
            )
            small = penalties.small_step
            _go_on(cost[v, u], total[v, u], now, before, column + 1, (small, jumps, back))


@kernel
def _jump(here: int, there: int, penalties: Penalties) -> int:
    """The cost of a jump of disparity between two grey levels."""
    large: int = penalties.large_step[abs(np.int64(here) - np.int64(there))]
    return large


@kernel
def _go_on(
    cost: ShortArray,
    total: ShortArray,
    now: _Ends,
    before: _Ends,
    place: int,
    steps: tuple[int, tuple[int, int, int, int], bool],
) -> None:
    """Continue the four paths to one pixel, and sum their costs there."""
    small, jumps, is_added = steps
    one = spread_short(small)
    along, first = now.costs[0, place - 1], before.costs[1, place - 1]
    second, third = before.costs[2, place], before.costs[3, place + 1]
    low_0, low_1 = now.lowest[0, place - 1], before.lowest[1, place - 1]
    low_2, low_3 = before.lowest[2, place], before.lowest[3, place + 1]
    base_0, base_1 = spread_short(low_0), spread_short(low_1)
    base_2, base_3 = spread_short(low_2), spread_short(low_3)
    jump_0, jump_1 = spread_short(low_0 + jumps[0]), spread_short(low_1 + jumps[1])
    jump_2, jump_3 = spread_short(low_2 + jumps[2]), spread_short(low_3 + jumps[3])
    least_0 = least_1 = least_2 = least_3 = spread_short(32767)
    for d in range(0, cost.size, NUM_SHORTS):
        here, k = load_shorts(cost, d), d + _RIM
        a = _best(along, k, one, jump_0) - base_0 + here
        b = _best(first, k, one, jump_1) - base_1 + here
        e = _best(second, k, one, jump_2) - base_2 + here
        f = _best(third, k, one, jump_3) - base_3 + here
        store_shorts(now.costs[0, place], k, a)
        store_shorts(now.costs[1, place], k, b)
        store_shorts(now.costs[2, place], k, e)
        store_shorts(now.costs[3, place], k, f)
        least_0, least_1 = lesser(least_0, a), lesser(least_1, b)
        least_2, least_3 = lesser(least_2, e), lesser(least_3, f)
        both = a + b + (e + f)
        if is_added:
            both = both + load_shorts(total, d)
        store_shorts(total, d, both)
    now.lowest[0, place], now.lowest[1, place] = least(least_0), least(least_1)
    now.lowest[2, place], now.lowest[3, place] = least(least_2), least(least_3)


@kernel
def _best(path: ShortArray, k: int, one: Shorts, jump: Shorts) -> Shorts:
    """The cheapest transition from the previous pixel."""
    sides = lesser(load_shorts(path, k - 1), load_shorts(path, k + 1)) + one
    return lesser(lesser(load_shorts(path, k), sides), jump)
