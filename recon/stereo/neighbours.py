"""The neighbours of a match, beyond the reach of its own support, and whether they agree with it.

Neighbours on one surface have like disparities; those of matches that noise created are random.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.simd import FAST, Floats, Integers

_BLOCK_PX = 8
"""Side of the blocks whose most confident match votes. The blocks that are asked surround a match
at a distance of two: their votes hardly depend on the pixels that support the match."""
_TOLERANCE_PX = 1
_LARGEST_SLANT_PX = 16
"""Largest difference of opposite blocks that a surface through the match explains."""
_OPPOSITE = ((-2, -2), (-2, -1), (-2, 0), (-2, 1), (-2, 2), (-1, -2), (0, -2), (1, -2))
"""Rows and columns of half of the surrounding blocks, relative to that of the match."""
_UNDECIDED = 2
"""Weight of an even vote, which a match without neighbours gets, as a number of blocks."""
_EMPTY = np.int32(1 << 24)


class Neighbours(NamedTuple):
    """How the blocks that surround each match vote."""

    agreement: Floats
    """(N,) share of those with a match that agree; even without neighbours."""
    company: Floats
    """(N,) share of all blocks that agree: fewer at a silhouette, even against empty sky."""


def neighbours(u: Integers, v: Integers, disparity: Integers, order: Integers) -> Neighbours:
    """Compare the disparities of matches with those around them.

    Opposite neighbours agree as well if the match lies between them, on a slanted surface.

    Parameters
    ----------
    u, v, disparity : (N,) whole pixels
    order : (N,)
        Ranks of the matches, most confident first.
    """
    shape = (v.max(initial=0) // _BLOCK_PX + 5, u.max(initial=0) // _BLOCK_PX + 5)
    found = Neighbours(np.empty(len(u), np.float32), np.empty(len(u), np.float32))
    blocks = np.full(shape, _EMPTY, np.int32)
    _elect((u, v, disparity), order, blocks)
    _vote((u, v, disparity), blocks, found)
    return found


@njit(cache=True, nogil=True)
def _elect(
    matches: tuple[Integers, Integers, Integers], order: Integers, blocks: NDArray[np.int32]
) -> None:
    """Write the disparity of the most confident match of each block."""
    u, v, disparity = matches
    best = np.full(blocks.shape, np.int64(1 << 60))
    for i in range(u.size):
        row, column = v[i] // _BLOCK_PX + 2, u[i] // _BLOCK_PX + 2
        if order[i] < best[row, column]:
            best[row, column] = order[i]
            blocks[row, column] = disparity[i]


@njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)
def _vote(
    matches: tuple[Integers, Integers, Integers], blocks: NDArray[np.int32], found: Neighbours
) -> None:
    """Write how the blocks that surround each match vote."""
    u, v, disparity = matches
    for i in range(u.size):
        row, column = v[i] // _BLOCK_PX + 2, u[i] // _BLOCK_PX + 2
        votes = count = 0
        for down, right in _OPPOSITE:
            here, there = blocks[row + down, column + right], blocks[row - down, column - right]
            a, b = here - disparity[i], there - disparity[i]
            known = (here != _EMPTY) + (there != _EMPTY)
            near = (abs(a) <= _TOLERANCE_PX) + (abs(b) <= _TOLERANCE_PX)
            slant = abs(a - b)
            is_between = 4 * abs(a + b) <= 8 * _TOLERANCE_PX + slant and slant <= _LARGEST_SLANT_PX
            votes += 2 if is_between and known == 2 else near
            count += known
        found.agreement[i] = np.float32(votes + 0.5 * _UNDECIDED) / np.float32(count + _UNDECIDED)
        found.company[i] = np.float32(votes) / np.float32(2 * len(_OPPOSITE))
