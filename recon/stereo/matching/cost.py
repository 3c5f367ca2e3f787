"""Similarity of a pixel to those of a row of the other image, at every shift (Eqs 16 to 18).

The image is processed in vertical strips, from top to bottom. Only the scores of the last rows of a
strip are kept, in a ring buffer of constant size that mostly fits into the cache.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.memory import aligned_empty, aligned_zeros
from recon.stereo.kernels.simd import (
    NUM_LANES,
    Floats,
    Lanes,
    filled,
    kernel,
    larger,
    load,
    one_earlier,
    one_later,
    prefetch,
    repeat,
    smaller,
    spread,
    store,
)
from recon.stereo.matching.windows import SIDE_RADIUS

SLACK = np.float32(0.9)
"""Weight of a member's score at the neighbouring shift."""

_RING_BYTES = 2 << 20
"""Maximum size of a ring."""
_NARROWEST = 64
"""Minimum columns of a strip, as it is computed with a margin on both sides."""
_TINY = np.float32(1e-12)


class Responses(NamedTuple):
    """One of the two images, in the layout of the loops."""

    planes: Floats
    """(H, C, 2, W') real and imaginary responses; C = scales * orientations."""
    mask: NDArray[np.bool_]
    """(H, W) pixels that may be matched."""
    grey: NDArray[np.uint8]
    """((H + 2 R) * (W + 2 R),) brightness, row by row, with a margin of R = SIDE_RADIUS."""


class Search(NamedTuple):
    """Pixel u is compared with the pixels u + first, u + first + 1, ... of the other image."""

    first: int
    num_shifts: int
    row_shift: int
    """Row of the other image minus the row of this one."""
    every: int
    """2: only pixels of every second row are members; 1: every second pixel of all rows."""
    is_unique: bool
    """True if only the best of the points of a row that choose the same partner is kept."""
    table: Floats
    """(S, B, P) similarity by scale, magnitude similarity c and cosine of the phase difference, in
    equal bins; (0, 0, 0) for the similarity c cos."""


C_COS = np.zeros((0, 0, 0), np.float32)
"""The table of the similarity ``c cos(phase difference)``."""


class Ring(NamedTuple):
    """Scores of the last rows of a strip: for every second pixel of a row, one lane per shift."""

    scores: Floats
    """(2 * rows * columns * lanes,) exact scores, then those with slack for slanted surfaces."""
    rows: int
    every: int
    """Step between image rows with scores; see `Search`."""
    columns: int
    lanes: int
    """Shifts, padded to multiples of 2 * `NUM_LANES`."""
    width: int
    """Image columns in a strip; with a margin of SIDE_RADIUS on both sides they are twice
    `columns`."""
    here: Floats
    """(C * 3 * reach,) responses and inverse energies of the strip's current row."""
    there: Floats
    """(C * 3 * reach,) the same for the row of the other image."""
    reach: int
    line: Floats
    """The scores of a pixel, with zeros for `NUM_LANES` before and after."""


def make_ring(num_channels: int, search: Search, size: int) -> Ring:
    """An empty ring for the strips of `size` columns of an image."""
    lanes = filled(search.num_shifts, 2 * NUM_LANES)
    rows = 2 * SIDE_RADIUS // search.every + 1
    fitting = _RING_BYTES // (2 * rows * lanes * 4) * 2 - 2 * SIDE_RADIUS
    num_strips = -(-size // max(fitting, _NARROWEST))
    width = filled(-(-size // num_strips))
    columns = width // 2 + SIDE_RADIUS
    reach = filled(2 * columns + 2 * NUM_LANES + lanes)
    return Ring(
        # Every line is written before it is read.
        scores=aligned_empty(2 * rows * columns * lanes),
        rows=rows,
        every=search.every,
        columns=columns,
        lanes=lanes,
        width=width,
        here=aligned_zeros(num_channels * 3 * reach),
        there=aligned_zeros(num_channels * 3 * reach),
        reach=reach,
        line=np.zeros(lanes + 2 * NUM_LANES, np.float32),
    )


@kernel
def line_start(ring: Ring, v: int) -> int:
    """Start of the exact scores of a row of the image."""
    return v // ring.every % ring.rows * ring.columns * ring.lanes


@kernel
def to_slack(ring: Ring) -> int:
    """Step from exact scores to those with slack."""
    return ring.rows * ring.columns * ring.lanes


@kernel
def fill_row(
    ring: Ring, v: int, first: int, base: Responses, other: Responses, search: Search
) -> None:
    """Compute the scores of row v, in the strip that starts at column `first`.

    Rows outside the image have score 0.
    """
    if v % ring.every:
        return
    size, start = ring.columns * ring.lanes, line_start(ring, v)
    lines = ring.scores[start:][:size], ring.scores[start + to_slack(ring) :][:size]
    height, v_other = base.mask.shape[0], v + search.row_shift
    if not (0 <= v < height and 0 <= v_other < height):
        lines[0][:] = 0.0
        lines[1][:] = 0.0
        return
    left = first - SIDE_RADIUS
    behind, behind_other = left % NUM_LANES, (left + search.first) % NUM_LANES
    _read(ring, base, v, left - behind, ring.here)
    _read(ring, other, v_other, left + search.first - behind_other, ring.there)
    # In even rows the even pixels are members, in odd rows the odd ones.
    _score(ring, (v & 1) + behind, (v & 1) + behind_other, search, lines)


@kernel
def _read(ring: Ring, image: Responses, v: int, origin: int, row: Floats) -> None:
    """Write responses and inverse energies, starting at a column that is a multiple of lanes.

    Inverse energies are 0 for pixels that cannot be matched.
    """
    reach = ring.reach
    channels, _, padded = image.planes.shape[1:]
    planes, plane = image.planes.reshape(-1), v * channels * 2 * padded + origin
    to_next_row = ring.every * channels * 2 * padded
    share = np.float32(1.0) / np.float32(channels)
    mask = image.mask[v]
    first, end = max(0, -origin), min(reach, padded - origin)
    # Outside the image, too: the row still contains another strip's.
    for c in range(channels):
        row[(3 * c + 2) * reach :][:reach] = 0.0
    weights = row[2 * reach :][:reach]
    for i in range(first, min(reach, mask.size - origin)):
        weights[i] = share if mask[origin + i] else np.float32(0.0)
    # The first channel last, since its inverse energies overwrite the weights.
    for c in range(channels - 1, -1, -1):
        for i in range(first, end, NUM_LANES):
            here, place = plane + 2 * c * padded + i, 3 * c * reach + i
            re, im = load(planes, here), load(planes, here + padded)
            store(row, place, re)
            store(row, place + reach, im)
            store(row, place + 2 * reach, load(weights, i) / (re * re + im * im + spread(_TINY)))
            # The next row, whose many short streams the processor does not foresee.
            prefetch(planes, here + to_next_row)
            prefetch(planes, here + to_next_row + padded)


@kernel
def _score(ring: Ring, here: int, there: int, search: Search, lines: tuple[Floats, Floats]) -> None:
    """Write the scores, exact and with slack, of every second pixel of a row."""
    for column in range(ring.columns):
        start = column * ring.lanes
        _score_pixel(ring, here + 2 * column, there + 2 * column, search, ring.line)
        _slacken(ring.line, start, lines)
        for i in range(search.num_shifts, ring.lanes):
            lines[1][start + i] = 0.0


@kernel
def _score_pixel(ring: Ring, u: int, start: int, search: Search, line: Floats) -> None:
    """Write the scores of one pixel; all are 0 if it cannot be matched."""
    if ring.here[2 * ring.reach + u] == 0.0:
        line[:] = 0.0
        return
    if search.table.size:
        _look_up(ring, u, start, search.table, line)
    else:
        _compare(ring, u, start, line)
    for i in range(search.num_shifts, ring.lanes):
        line[NUM_LANES + i] = 0.0


@kernel
def _compare(ring: Ring, u: int, start: int, line: Floats) -> None:
    """Mean over scales and orientations of c cos(phase difference).

    ``Re(r conj r') / max(|r|^2, |r'|^2)`` is c cos, without computing an angle or a root.
    """
    here, there, reach = ring.here, ring.there, ring.reach
    # The orientations of one scale at a time.
    for scale in range(0, here.size, 9 * reach):
        a = _response(here, scale + u, reach)
        b = _response(here, scale + 3 * reach + u, reach)
        d = _response(here, scale + 6 * reach + u, reach)
        for i in range(0, ring.lanes, NUM_LANES):
            k = scale + start + i
            score = _alike(a, there, k, reach)
            score += _alike(b, there, k + 3 * reach, reach)
            score += _alike(d, there, k + 6 * reach, reach)
            if scale:
                score += load(line, NUM_LANES + i)
            store(line, NUM_LANES + i, score)


@kernel
def _response(here: Floats, k: int, reach: int) -> tuple[Lanes, Lanes, Lanes]:
    """Response and inverse energy of one pixel in one channel."""
    return repeat(here, k), repeat(here, k + reach), repeat(here, k + 2 * reach)


@kernel
def _alike(response: tuple[Lanes, Lanes, Lanes], there: Floats, k: int, reach: int) -> Lanes:
    """c cos of a response and those of the other row, starting at index k."""
    real, imag, inverse = response
    dot = real * load(there, k) + imag * load(there, k + reach)
    return dot * smaller(inverse, load(there, k + 2 * reach))


@kernel
def _look_up(ring: Ring, u: int, start: int, table: Floats, line: Floats) -> None:
    """Mean over scales and orientations of the table's similarity."""
    scales, num_c, num_cos = table.shape
    here = ring.here.reshape(-1, 3, ring.reach)
    there = ring.there.reshape(-1, 3, ring.reach)
    channels = len(here)
    for k in range(start, start + ring.lanes):
        line[NUM_LANES + k - start] = 0.0
        if there[0, 2, k] == 0.0:
            continue
        total = np.float32(0.0)
        for c in range(channels):
            dot = here[c, 0, u] * there[c, 0, k] + here[c, 1, u] * there[c, 1, k]
            # The inverse energies of both have the same factor.
            ratio = here[c, 2, u] / there[c, 2, k]
            like = np.sqrt(min(ratio, 1.0 / ratio))
            cosine = dot * channels * np.sqrt(here[c, 2, u] * there[c, 2, k])
            row = min(int(like * num_c), num_c - 1)
            column = min(max(int((cosine + 1.0) * 0.5 * num_cos), 0), num_cos - 1)
            total += table[c * scales // channels, row, column]
        line[NUM_LANES + k - start] = total / channels


@kernel
def _slacken(line: Floats, start: int, lines: tuple[Floats, Floats]) -> None:
    """Write the scores, clipped to >= 0, and the maximum of each and its neighbours.

    The neighbours are weighted by `SLACK`.
    """
    before, here = load(line, 0), load(line, NUM_LANES)
    for i in range(NUM_LANES, line.size - NUM_LANES, NUM_LANES):
        # Scores that were just stored are slow to load from other positions.
        after = load(line, i + NUM_LANES)
        exact = larger(here, spread(0.0))
        beside = larger(one_earlier(before, here), one_later(here, after))
        before, here = here, after
        place = start + i - NUM_LANES
        store(lines[0], place, exact)
        store(lines[1], place, larger(exact, SLACK * beside))
