"""Semi-global aggregation: the cost of the best way to each pixel along eight directions.

Hirschmueller's method (2008): along each direction a step of one disparity costs `small_step`, a
larger one `large_step`, which is lower where the grey level changes, as surfaces end there.
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
"""Entries before the first disparity of a row of the paths, and after the last."""


class Penalties(NamedTuple):
    """Of changes of disparity, in the unit of the costs."""

    small_step: int
    """One pixel of disparity from pixel to pixel."""
    large_step: ShortArray
    """(256,) more than one, by the difference of the grey levels."""


def aggregate(
    cost: ShortArray, grey: NDArray[np.uint8], penalties: Penalties
) -> ShortArray:
    """Sum of the costs of the best ways to each pixel from eight sides.

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


@njit(cache=True, nogil=True)
def _sweep(
    cost: ShortArray, grey: NDArray[np.uint8], penalties: Penalties, total: ShortArray, back: bool
) -> None:
    """Four directions in one sweep: along the row, and from the three neighbours before it.

    Backwards, everything goes from the last pixel to the first.
    """
    height, width, depth = cost.shape
    paths = np.full((2, 4, width + 2, depth + 2 * _RIM), _EDGE, np.int16)
    paths[:, :, :, _RIM:-_RIM] = 0
    lowest = np.zeros((2, 4, width + 2), np.int16)
    step = -1 if back else 1
    for row in range(height):
        v = height - 1 - row if back else row
        now, before = row % 2, 1 - row % 2
        above = v - step if row else v
        for column in range(width):
            u = width - 1 - column if back else column
            # Number 0 and the last of the buffers lie outside the image.
            place = column + 1
            if column == 0:
                _begin(paths[now, 0, 0], lowest[now, 0])
            behind, ahead = (u - step if column else u), min(max(u + step, 0), width - 1)
            here = np.int64(grey[v, u])
            larges = (
                penalties.large_step[abs(here - np.int64(grey[v, behind]))],
                penalties.large_step[abs(here - np.int64(grey[above, behind]))],
                penalties.large_step[abs(here - np.int64(grey[above, u]))],
                penalties.large_step[abs(here - np.int64(grey[above, ahead]))],
            )
            _step(
                cost[v, u], total[v, u], paths[now], paths[before], lowest[now], lowest[before],
                place, penalties.small_step, larges, back,
            )
        _close(paths[now], lowest[now])


@kernel
def _begin(path: ShortArray, lowest: ShortArray) -> None:
    path[_RIM:-_RIM] = 0
    lowest[0] = 0


@kernel
def _close(paths: ShortArray, lowest: ShortArray) -> None:
    """What comes from outside the image has cost nothing so far."""
    paths[1:, 0, _RIM:-_RIM] = 0
    paths[1:, -1, _RIM:-_RIM] = 0
    lowest[1:, 0] = 0
    lowest[1:, -1] = 0


@kernel
def _step(  # noqa: PLR0913
    cost, total, now, before, low_now, low_before, place, small, larges, is_added
) -> None:
    along = now[0, place - 1]
    first, second, third = before[1, place - 1], before[2, place], before[3, place + 1]
    low_0, low_1 = low_now[0, place - 1], low_before[1, place - 1]
    low_2, low_3 = low_before[2, place], low_before[3, place + 1]
    base_0, base_1 = spread_short(low_0), spread_short(low_1)
    base_2, base_3 = spread_short(low_2), spread_short(low_3)
    jump_0, jump_1 = spread_short(low_0 + larges[0]), spread_short(low_1 + larges[1])
    jump_2, jump_3 = spread_short(low_2 + larges[2]), spread_short(low_3 + larges[3])
    one = spread_short(small)
    m0 = m1 = m2 = m3 = spread_short(32767)
    for d in range(0, cost.size, NUM_SHORTS):
        c = load_shorts(cost, d)
        k = d + _RIM
        a = _best(along, k, one, jump_0) - base_0 + c
        store_shorts(now[0, place], k, a)
        m0 = lesser(m0, a)
        b = _best(first, k, one, jump_1) - base_1 + c
        store_shorts(now[1, place], k, b)
        m1 = lesser(m1, b)
        e = _best(second, k, one, jump_2) - base_2 + c
        store_shorts(now[2, place], k, e)
        m2 = lesser(m2, e)
        f = _best(third, k, one, jump_3) - base_3 + c
        store_shorts(now[3, place], k, f)
        m3 = lesser(m3, f)
        s = a + b + (e + f)
        if is_added:
            s = s + load_shorts(total, d)
        store_shorts(total, d, s)
    low_now[0, place] = least(m0)
    low_now[1, place] = least(m1)
    low_now[2, place] = least(m2)
    low_now[3, place] = least(m3)


@kernel
def _best(path: ShortArray, k: int, one: Shorts, jump: Shorts) -> Shorts:
    """The cheapest way to go on from the pixel before."""
    sides = lesser(load_shorts(path, k - 1), load_shorts(path, k + 1)) + one
    return lesser(lesser(load_shorts(path, k), sides), jump)
