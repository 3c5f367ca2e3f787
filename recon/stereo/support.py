"""The support that the pixels round a point give to each of its disparities.

Every second pixel, as on a chessboard, is a member: nothing is lost by it. The members of a window
are listed once, by the parity of its middle, so that the loop over them has no branches.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Integers = NDArray[np.int64]

RADIUS = 7
"""Of the disc whose pixels support a disparity."""
SIDE_RADIUS = 10
"""Of the two half discs that tell which side of an edge has the disparity."""
_SPREAD = 5.0
"""Standard deviation of the weight of a member, in pixels."""
_RIGID = 3.0
"""Up to this distance a member supports its own disparity alone; farther ones, the next too."""
_SIDE_GAP = 1.5
"""Distance from the edge at which a half disc begins."""
_CONTRAST = 20.0
"""Difference of grey levels at which a member's support has fallen to 1/e: it belongs elsewhere."""
DIRECTIONS = 16
"""Number of normals, over half a turn, for which half discs are listed."""
_UNROLL = 4
"""Members that are added at once, so that sums stay in registers."""

FAST = {"contract", "nsz", "nnan"}
"""What compilers may do to sums: nothing that depends on the number of threads or the run."""


class Members(NamedTuple):
    """Pixels of windows: (..., K) arrays, filled up with weight 0 to a multiple of `_UNROLL`."""

    dv: Integers
    du: Integers
    weight: Floats
    slack: Integers
    """1 where the member may vote with a neighbouring disparity too."""


def _disc(radius: int) -> tuple[Integers, Integers, Floats]:
    dv, du = np.mgrid[-radius : radius + 1, -radius : radius + 1].reshape(2, -1)
    inside = dv**2 + du**2 <= radius**2
    dv, du = dv[inside], du[inside]
    return dv, du, np.exp(-(dv**2 + du**2) / (2 * _SPREAD**2)).astype(np.float32)


def _stacked(windows: list[tuple[Integers, Integers, Floats]]) -> Members:
    """Windows of different sizes as rows of one table."""
    longest = max(len(weight) for _, _, weight in windows)
    shape = (len(windows), -(-longest // _UNROLL) * _UNROLL)
    table = Members(
        np.zeros(shape, np.int64), np.zeros(shape, np.int64), np.zeros(shape, np.float32),
        np.zeros(shape, np.int64),
    )  # fmt: skip
    for row, (dv, du, weight) in enumerate(windows):
        size = len(weight)
        table.dv[row, :size] = dv
        table.du[row, :size] = du
        table.weight[row, :size] = weight
        table.slack[row, :size] = dv**2 + du**2 > _RIGID**2
    return table


def _whole() -> Members:
    """The disc, for both parities of its middle."""
    dv, du, weight = _disc(RADIUS)
    chosen = [(dv + du) % 2 == parity for parity in (0, 1)]
    return _stacked([(dv[rows], du[rows], weight[rows]) for rows in chosen])


def _half(sign: int) -> Members:
    """The half disc ahead of (+1) or behind (-1) an edge, by parity and then by direction."""
    dv, du, weight = _disc(SIDE_RADIUS)
    windows = []
    for parity in (0, 1):
        for direction in np.arange(DIRECTIONS) * np.pi / DIRECTIONS:
            ahead = sign * (du * np.cos(direction) + dv * np.sin(direction)) >= _SIDE_GAP
            rows = ahead & ((dv + du) % 2 == parity)
            windows.append((dv[rows], du[rows], weight[rows]))
    return _stacked(windows)


DISC = _whole()
AHEAD = _half(+1)
BEHIND = _half(-1)
LIKENESS = np.exp(-np.arange(256) / _CONTRAST).astype(np.float32)


@njit(cache=True, fastmath=FAST, error_model="numpy")
def add_votes(scores: Floats, starts: Integers, weights: Floats, total: Floats) -> None:
    """Weighted sum of the members' scores, which lie in `scores` from `starts` on."""
    size = total.size
    total[:] = 0.0
    for k in range(0, weights.size, _UNROLL):
        # Slices, as an index that might be negative keeps the loop from being vectorised.
        a, b = scores[starts[k] :][:size], scores[starts[k + 1] :][:size]
        c, d = scores[starts[k + 2] :][:size], scores[starts[k + 3] :][:size]
        p, q, r, s = weights[k], weights[k + 1], weights[k + 2], weights[k + 3]
        for i in range(size):
            total[i] += p * a[i] + q * b[i] + r * c[i] + s * d[i]
