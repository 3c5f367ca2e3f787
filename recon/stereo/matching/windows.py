"""The support that the pixels around a point give to each of its disparities.

Every second pixel, in a chessboard pattern, is a member, which loses nothing. The members of a
window are listed once, by the parity of its centre, so that the loop over them has no branches.
"""

from functools import cache, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.shorts import WHOLE, ShortArray
from recon.stereo.kernels.simd import Floats, Integers, filled

RADIUS = 7
"""Radius of the disc whose pixels support a disparity."""
SIDE_RADIUS = 10
"""Radius of the two half discs that determine which side of an edge has the disparity."""
_SPREAD = 5.0
"""Standard deviation of the weight of a member, in pixels."""
_RIGID = 3.0
"""Up to this distance a member supports only its own disparity; farther ones, the next, too."""
_SIDE_GAP = 1.5
"""Distance from the edge at which a half disc starts."""
_CONTRAST = 20.0
"""Difference of grey levels at which a member's support has decayed to 1/e."""
DIRECTIONS = 16
"""Number of normals, over half a turn, for which half discs are listed."""


class Members(NamedTuple):
    """Pixels of windows: (..., K) arrays, padded with weight 0."""

    dv: Integers
    du: Integers
    weight: Floats
    slack: Integers
    """1 where the member may also vote with a neighbouring disparity."""


def _disc(radius: int) -> tuple[Integers, Integers, Floats]:
    dv, du = np.mgrid[-radius : radius + 1, -radius : radius + 1].reshape(2, -1)
    inside = dv**2 + du**2 <= radius**2
    dv, du = dv[inside], du[inside]
    return dv, du, np.exp(-(dv**2 + du**2) / (2 * _SPREAD**2)).astype(np.float32)


def _stacked(windows: list[tuple[Integers, Integers, Floats]]) -> Members:
    """Windows of different sizes as rows of one table."""
    longest = max(len(weight) for _, _, weight in windows)
    shape = (len(windows), filled(longest))
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


def _chosen(dv: Integers, du: Integers, odd_v: int, odd_u: int, every: int) -> NDArray[np.bool_]:
    """Mask of the pixels of a window that are members, by the parities of its centre."""
    if every == 2:
        return np.asarray((dv % 2 == odd_v) & (du % 2 == odd_u))
    return np.asarray((dv + du) % 2 == (odd_v + odd_u) % 2)


@cache
def disc(every: int) -> Members:
    """The disc, by the parity of its centre's row, then column."""
    dv, du, weight = _disc(RADIUS)
    windows = []
    for odd_v, odd_u in product((0, 1), repeat=2):
        rows = _chosen(dv, du, odd_v, odd_u, every)
        windows.append((dv[rows], du[rows], weight[rows]))
    return _stacked(windows)


@cache
def half_disc(sign: int, every: int) -> Members:
    """The half disc ahead of (+1) or behind (-1) an edge, by parities and then by direction."""
    dv, du, weight = _disc(SIDE_RADIUS)
    windows = []
    for odd_v, odd_u in product((0, 1), repeat=2):
        chosen = _chosen(dv, du, odd_v, odd_u, every)
        for direction in (np.arange(DIRECTIONS) + 0.5) * np.pi / DIRECTIONS:
            ahead = sign * (du * np.cos(direction) + dv * np.sin(direction)) >= _SIDE_GAP
            rows = ahead & chosen
            windows.append((dv[rows], du[rows], weight[rows]))
    return _stacked(windows)


class Window(NamedTuple):
    """Members of the windows of one kind, as ring offsets; (T, K) by parities and direction."""

    row: Integers
    """Rows of a ring below the centre's."""
    offset: Integers
    """Offset from the scores of the window's centre, if the ring does not wrap between them."""
    pixel: Integers
    """Offset from the centre in the flat image with its margin."""
    weight: Floats
    share: ShortArray
    """The weights as shares of their sum."""


@lru_cache(maxsize=16)
def windows(every: int, steps: tuple[int, int, int], stride: int) -> tuple[Window, Window, Window]:
    """The disc, and the half discs ahead and behind, in a ring and in a flat image.

    Parameters
    ----------
    every : int
        2: only pixels of every second row are members; 1: every second pixel of all rows.
    steps : (int, int, int)
        From the scores of one member of a row to those of the next, of one row to those of the
        next, and from exact scores to those with slack.
    stride : int
        Step from row to row of the image.
    """
    kinds = disc(every), half_disc(+1, every), half_disc(-1, every)
    ours, ahead, behind = (_window(members, every, steps, stride) for members in kinds)
    return ours, ahead, behind


def _window(members: Members, every: int, steps: tuple[int, int, int], stride: int) -> Window:
    # Rows of the tables are by parity of the centre's row, then of its column.
    number = np.arange(len(members.du)) * 4 // len(members.du)
    row = (members.dv + number[:, None] // 2) // every if every > 1 else members.dv
    column = (number[:, None] % 2 + members.du) >> 1
    lanes, line, slack = steps
    share = members.weight / members.weight.sum(axis=1, keepdims=True)
    return Window(
        row=row,
        offset=column * lanes + row * line + members.slack * slack,
        pixel=members.dv * stride + members.du,
        weight=members.weight,
        share=np.rint(share * (WHOLE - 1)).astype(np.int16),
    )


LIKENESS = np.exp(-np.abs(np.arange(-255, 256)) / _CONTRAST).astype(np.float32)
"""Factor of the weight of a pixel, by its grey level minus that of the centre, from -255 on."""
