"""Similarity of a pixel to those of the other picture's row, at every disparity (Eqs 16 to 18).

The scores of the rows round the current one stay in a ring, so that memory does not grow with the
height of the picture.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.support import FAST, SIDE_RADIUS, Floats, Integers, Members

SLACK = np.float32(0.9)
"""What a member's vote for the neighbouring disparity is worth."""

_ROWS = 2 * SIDE_RADIUS + 1
_MARGIN = SIDE_RADIUS
_TINY = np.float32(1e-12)


class Side(NamedTuple):
    """One picture of the two, as the loops want it."""

    planes: Floats
    """(S, O, 2, H, W) responses."""
    mask: NDArray[np.bool_]
    """(H, W) pixels that may be matched."""
    grey: NDArray[np.uint8]
    """(H + 2 R, W + 2 R) brightness with a margin of R = SIDE_RADIUS."""


class Search(NamedTuple):
    """Where the other picture is searched."""

    lowest: int
    """Smallest disparity."""
    num_disparities: int
    row_shift: int
    """Row of the other picture, less the row of this one."""


class Ring(NamedTuple):
    """Scores of the last rows: every second pixel of a row, and for it one lane a disparity."""

    scores: Floats
    """(2 * _ROWS * columns * lanes,) exact scores, then those that a slanted surface may use."""
    columns: int
    lanes: int
    """Disparities, one lane that is 1 where the pixel is a candidate, and filling to 16."""


@njit(cache=True)
def make_ring(width: int, count: int) -> Ring:
    """An empty ring."""
    lanes = (count + 1 + 15) // 16 * 16
    columns = (width + 2 * _MARGIN) // 2 + 1
    return Ring(np.zeros(2 * _ROWS * columns * lanes, np.float32), columns, lanes)


@njit(cache=True, error_model="numpy")
def locate(ring: Ring, v: int, members: Members, starts: Integers) -> None:
    """Where the members of windows with middle row v lie, for even (0) and odd (1) columns.

    Counted from the column `u >> 1` of the window's middle u.
    """
    rows = members.weight.shape[0] // 2
    slack_shift = _ROWS * ring.columns * ring.lanes
    for odd in range(2):
        for i in range(rows):
            row = ((odd + v) & 1) * rows + i
            for k in range(members.weight.shape[1]):
                line = (v + members.dv[row, k]) % _ROWS * ring.columns
                column = (odd + members.du[row, k] + _MARGIN) >> 1
                shift = members.slack[row, k] * slack_shift
                starts[odd, i, k] = (line + column) * ring.lanes + shift


@njit(cache=True, fastmath=FAST, error_model="numpy")
def fill_row(ring: Ring, v: int, base: Side, other: Side, search: Search) -> None:
    """Compute the scores of row v of `base`; rows outside the picture score nothing."""
    size = ring.columns * ring.lanes
    start = v % _ROWS * size
    exact = ring.scores[start : start + size]
    exact[:] = 0.0
    slack = ring.scores[start + _ROWS * size : start + (_ROWS + 1) * size]
    slack[:] = 0.0
    height, width = base.mask.shape
    v_other = v + search.row_shift
    if not (0 <= v < height and 0 <= v_other < height):
        return
    mirror = _mirrored(other.planes[:, :, :, v_other], other.mask[v_other], search)
    here = _energies(base.planes[:, :, :, v], base.mask[v])
    first = max(0, -search.lowest) + width - 1 + search.lowest
    for u in range(v & 1, width, 2):
        if base.mask[v, u]:
            lane = ((u + _MARGIN) >> 1) * ring.lanes
            lanes = exact[lane : lane + ring.lanes]
            for scale in range(mirror.shape[0]):
                _add_scores(here[u, scale], mirror[scale], first - u, search.num_disparities, lanes)
            lanes[search.num_disparities] = 1.0
            _slacken(lanes, search.num_disparities, slack[lane : lane + ring.lanes])


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _energies(planes: Floats, mask: NDArray[np.bool_]) -> Floats:
    """(W, S, O, 3) responses and inverse energies of the candidates of a row."""
    scales, orientations, _, width = planes.shape
    row = np.empty((width, scales, orientations, 3), np.float32)
    share = np.float32(1.0 / (scales * orientations))
    for s in range(scales):
        for o in range(orientations):
            for u in range(width):
                re, im = planes[s, o, 0, u], planes[s, o, 1, u]
                row[u, s, o, 0] = re
                row[u, s, o, 1] = im
                row[u, s, o, 2] = share / (re * re + im * im + _TINY)
    return row


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _mirrored(planes: Floats, mask: NDArray[np.bool_], search: Search) -> Floats:
    """A row back to front, so that the disparity grows with the index, with inverse energies."""
    scales, orientations, _, width = planes.shape
    offset = max(0, -search.lowest)
    size = offset + 2 * width + max(0, search.lowest) + search.num_disparities
    mirror = np.zeros((scales, orientations, 3, size), np.float32)
    share = np.float32(1.0 / (scales * orientations))
    for s in range(scales):
        for o in range(orientations):
            row = mirror[s, o]
            for u in range(width):
                re, im = planes[s, o, 0, u], planes[s, o, 1, u]
                i = offset + width - 1 - u
                row[0, i] = re
                row[1, i] = im
                # No candidate: no score, whatever the phase.
                row[2, i] = share / (re * re + im * im + _TINY) if mask[u] else np.float32(0.0)
    return mirror


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _add_scores(here: Floats, mirror: Floats, first: int, count: int, out: Floats) -> None:
    """Add c cos(phase difference) of the three orientations of one scale.

    ``Re(r conj r') / max(|r|^2, |r'|^2)`` is that, without an angle or a root.
    """
    for o in range(3):
        re, im, inverse = here[o]
        # Slices, as an index that might be negative keeps the loop from being vectorised.
        re_other = mirror[o, 0, first:][:count]
        im_other = mirror[o, 1, first:][:count]
        inverse_other = mirror[o, 2, first:][:count]
        for d in range(count):
            out[d] += (re * re_other[d] + im * im_other[d]) * min(inverse, inverse_other[d])


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _slacken(exact: Floats, count: int, slack: Floats) -> None:
    """The best of a score and its neighbours', these at a discount."""
    slack[:] = exact
    for d in range(1, count):
        slack[d] = max(slack[d], SLACK * exact[d - 1])
    for d in range(count - 1):
        slack[d] = max(slack[d], SLACK * exact[d + 1])
