"""Similarity of a pixel to those of the other picture's row, at every shift (Eqs 16 to 18).

The scores of the rows round the current one stay in a ring, so that memory does not grow with the
height of the picture.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.lanes import FAST, Floats, Integers, kernel
from recon.stereo.support import SIDE_RADIUS, Members

SLACK = np.float32(0.9)
"""What a member's vote for the neighbouring shift is worth."""

_MARGIN = SIDE_RADIUS
_TINY = np.float32(1e-12)


class Picture(NamedTuple):
    """One picture of the two, as the loops want it."""

    planes: Floats
    """(C, 2, H, W) real and imaginary responses; C = scales * orientations."""
    mask: NDArray[np.bool_]
    """(H, W) pixels that may be matched."""
    grey: NDArray[np.uint8]
    """(H + 2 R, W + 2 R) brightness with a margin of R = SIDE_RADIUS."""


class Search(NamedTuple):
    """Pixel u is compared with the pixels u + first, u + first + 1, ... of the other picture."""

    first: int
    num_shifts: int
    row_shift: int
    """Row of the other picture, less the row of this one."""
    every: int
    """2: pixels of every second row alone are members; 1: every second pixel of all rows."""
    is_unique: bool
    """Whether of the points of a row that choose the same partner only the best is kept."""
    table: Floats
    """(S, B, P) similarity by scale, likeness of magnitude c and cosine of the phase difference,
    each in equal bins; (0, 0, 0) for the similarity c cos."""


C_COS = np.zeros((0, 0, 0), np.float32)
"""The table of the similarity ``c cos(phase difference)``."""


class Ring(NamedTuple):
    """Scores of the last rows: every second pixel of a row, and for it one lane a shift."""

    scores: Floats
    """(2 * rows * columns * lanes,) exact scores, then those that a slanted surface may use."""
    rows: int
    every: int
    """Which rows of the picture have scores; see `Search`."""
    lines: Integers
    """(2 * SIDE_RADIUS + 1,) where the rows of a window begin; room for `locate`."""
    columns: int
    lanes: int
    """Shifts, filled up to a multiple of 16."""


@njit(cache=True)
def make_ring(width: int, num_shifts: int, every: int) -> Ring:
    """An empty ring."""
    lanes = (num_shifts + 15) // 16 * 16
    columns = (width + 2 * _MARGIN) // 2 + 1
    rows = 2 * SIDE_RADIUS // every + 1
    scores = np.zeros(2 * rows * columns * lanes, np.float32)
    lines = np.zeros(2 * SIDE_RADIUS + 1, np.int64)
    return Ring(scores, rows, every, lines, columns, lanes)


@kernel
def locate(ring: Ring, v: int, members: Members, starts: Integers) -> None:
    """Where the members of windows with middle row v lie, for even (0) and odd (1) columns.

    Counted from the column `u >> 1` of the window's middle u.
    """
    slack_shift = ring.rows * ring.columns * ring.lanes
    for k in range(ring.lines.size):
        line = (v + k - SIDE_RADIUS) // ring.every % ring.rows
        ring.lines[k] = line * ring.columns * ring.lanes
    for odd in range(2):
        for i in range(starts.shape[1]):
            row = (2 * (v & 1) + odd) * starts.shape[1] + i
            for k in range(starts.shape[2]):
                line = ring.lines[members.dv[row, k] + SIDE_RADIUS]
                column = (odd + members.du[row, k] + _MARGIN) >> 1
                shift = members.slack[row, k] * slack_shift
                starts[odd, i, k] = line + column * ring.lanes + shift


@njit(cache=True, fastmath=FAST, error_model="numpy")
def fill_row(ring: Ring, v: int, base: Picture, other: Picture, search: Search) -> None:
    """Compute the scores of row v of `base`; rows outside the picture score nothing."""
    if v % ring.every:
        return
    size = ring.columns * ring.lanes
    start = v // ring.every % ring.rows * size
    exact = ring.scores[start : start + size]
    slack = ring.scores[start + ring.rows * size :][:size]
    height = base.mask.shape[0]
    v_other = v + search.row_shift
    if not (0 <= v < height and 0 <= v_other < height):
        exact[:] = 0.0
        slack[:] = 0.0
        return
    margin = max(0, -search.first)
    beyond = max(0, search.first) + search.num_shifts
    here = _row(base, v, 0, 0)
    there = _row(other, v_other, margin, beyond)
    start = margin + search.first
    lines = exact.reshape(-1, ring.lanes), slack.reshape(-1, ring.lanes)
    _score(base.mask[v], v & 1, here, there, start, search, lines)


@kernel
def _score(
    mask: NDArray[np.bool_],
    odd: int,
    here: Floats,
    there: Floats,
    start: int,
    search: Search,
    lines: tuple[Floats, Floats],
) -> None:
    """Scores, exact and slack, of every second pixel of a row, the first of which is `odd`."""
    for u in range(odd, mask.size, 2):
        column = (u + _MARGIN) >> 1
        exact = lines[0][column, : search.num_shifts]
        slack = lines[1][column, : search.num_shifts]
        if not mask[u]:
            exact[:] = 0.0
            slack[:] = 0.0
            continue
        if search.table.size:
            _look_up(here, u, there[:, :, start + u :], search.table, exact)
        else:
            _compare(here, u, there, start + u, exact)
        _slacken(exact, slack)


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _row(picture: Picture, v: int, margin: int, beyond: int) -> Floats:
    """(C, 3, ...) responses and inverse energies of a row, with room before and behind."""
    channels, _, _, width = picture.planes.shape
    row = np.zeros((channels, 3, margin + width + beyond), np.float32)
    share = np.float32(1.0 / channels)
    mask = picture.mask[v]
    for c in range(channels):
        real, imag = picture.planes[c, 0, v], picture.planes[c, 1, v]
        re, im = row[c, 0, margin:], row[c, 1, margin:]
        inverse = row[c, 2, margin:]
        for u in range(width):
            re[u] = real[u]
            im[u] = imag[u]
            # No candidate: no score, whatever the phase.
            weight = share if mask[u] else np.float32(0.0)
            inverse[u] = weight / (real[u] * real[u] + imag[u] * imag[u] + _TINY)
    return row


@kernel
def _compare(here: Floats, u: int, there: Floats, start: int, scores: Floats) -> None:
    """Mean over scales and orientations of c cos(phase difference), where that is positive.

    ``Re(r conj r') / max(|r|^2, |r'|^2)`` is c cos, without an angle or a root.
    """
    # Unsigned, as an index that might be negative keeps the loop from being vectorised.
    first = np.uint64(start)
    size = np.uint64(scores.size)
    scores[:] = 0.0
    for c in range(0, here.shape[0], 3):
        a, b, d = there[c], there[c + 1], there[c + 2]
        a_re, a_im, a_inv = here[c, 0, u], here[c, 1, u], here[c, 2, u]
        b_re, b_im, b_inv = here[c + 1, 0, u], here[c + 1, 1, u], here[c + 1, 2, u]
        d_re, d_im, d_inv = here[c + 2, 0, u], here[c + 2, 1, u], here[c + 2, 2, u]
        for i in range(size):
            k = first + i
            scores[i] += (
                (a_re * a[0, k] + a_im * a[1, k]) * min(a_inv, a[2, k])
                + (b_re * b[0, k] + b_im * b[1, k]) * min(b_inv, b[2, k])
                + (d_re * d[0, k] + d_im * d[1, k]) * min(d_inv, d[2, k])
            )
    for i in range(size):
        scores[i] = max(scores[i], np.float32(0.0))


@kernel
def _look_up(here: Floats, u: int, there: Floats, table: Floats, scores: Floats) -> None:
    """Mean over scales and orientations of the table's similarity, where that is positive."""
    scales, num_c, num_cos = table.shape
    channels = here.shape[0]
    for i in range(scores.size):
        scores[i] = 0.0
        if there[0, 2, i] == 0.0:
            continue
        total = np.float32(0.0)
        for c in range(channels):
            dot = here[c, 0, u] * there[c, 0, i] + here[c, 1, u] * there[c, 1, i]
            # The inverse energies of both have the same factor.
            ratio = here[c, 2, u] / there[c, 2, i]
            like = np.sqrt(min(ratio, 1.0 / ratio))
            cosine = dot * channels * np.sqrt(here[c, 2, u] * there[c, 2, i])
            row = min(int(like * num_c), num_c - 1)
            column = min(max(int((cosine + 1.0) * 0.5 * num_cos), 0), num_cos - 1)
            total += table[c * scales // channels, row, column]
        scores[i] = max(total / channels, np.float32(0.0))


@kernel
def _slacken(exact: Floats, slack: Floats) -> None:
    """The best of a score and its neighbours', these at a discount."""
    size = exact.size
    if size == 1:
        slack[0] = exact[0]
        return
    slack[0] = max(exact[0], SLACK * exact[1])
    slack[size - 1] = max(exact[size - 1], SLACK * exact[size - 2])
    before, middle, after, out = exact[: size - 2], exact[1 : size - 1], exact[2:], slack[1:]
    for d in range(size - 2):
        out[d] = max(middle[d], SLACK * max(before[d], after[d]))
