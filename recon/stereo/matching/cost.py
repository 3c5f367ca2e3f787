"""Similarity of a pixel to those of a row of the other image, at every shift (Eqs 16 to 18).

The image is processed in vertical strips, from top to bottom.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.shorts import (
    NUM_SHORTS,
    WHOLE,
    ShortArray,
    Shorts,
    greater,
    part,
    rounded,
    short_earlier,
    short_later,
    spread_short,
    store_shorts,
)
from recon.stereo.kernels.simd import (
    NUM_LANES,
    Floats,
    Lanes,
    kernel,
    larger,
    load,
    prefetch,
    repeat,
    smaller,
    spread,
    store,
)
from recon.stereo.matching.ring import ONE, RIMS, Ring, line_start, to_slack
from recon.stereo.matching.search import Search
from recon.stereo.matching.windows import SIDE_RADIUS

SLACK = round(0.9 * WHOLE)
"""Weight of a member's score at the neighbouring shift, as a share."""

_TINY = np.float32(1e-12)
_APART = NUM_LANES // 2
"""Distance, in columns of a ring, of two pixels that are scored at once."""

_Response = tuple[Lanes, Lanes, Lanes]
"""Real and imaginary part and inverse energy of one pixel in one channel, in all lanes."""


class Responses(NamedTuple):
    """One of the two images, in the layout of the loops."""

    planes: Floats
    """(H, C, 2, W') real and imaginary responses; C = scales * orientations."""
    factor: np.float32
    """Of the responses: 1 / gain."""
    mask: NDArray[np.bool_]
    """(H, W) pixels that may be matched."""
    grey: NDArray[np.uint8]
    """((H + 2 R) * (W + 2 R),) brightness, row by row, with a margin of R = SIDE_RADIUS."""


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
        lines[0][:] = 0
        lines[1][:] = 0
        return
    left = first - SIDE_RADIUS
    behind, behind_other = left % NUM_LANES, (left + search.first) % NUM_LANES
    _read(base, v, left - behind, ring.every, (ring.here, ring.reach_here))
    origin = left + search.first - behind_other
    _read(other, v_other, origin, ring.every, (ring.there, ring.reach))
    # In even rows the even pixels are members, in odd rows the odd ones.
    _score(ring, (v & 1) + behind, (v & 1) + behind_other, search, lines)


@kernel
def _read(image: Responses, v: int, origin: int, every: int, target: tuple[Floats, int]) -> None:
    """Write responses and inverse energies, starting at a column that is a multiple of lanes.

    Inverse energies are 0 for pixels that cannot be matched.
    """
    row, reach = target
    channels, _, padded = image.planes.shape[1:]
    planes, plane = image.planes.reshape(-1), v * channels * 2 * padded + origin
    to_next_row = every * channels * 2 * padded
    share = np.float32(1.0) / np.float32(channels)
    first, end = max(0, -origin), min(reach, padded - origin)
    # Outside the image, too: the row still contains another strip's.
    for c in range(channels):
        row[(3 * c + 2) * reach :][:reach] = 0.0
    weights = row[2 * reach :][:reach]
    # Slices that begin at 0: indices that might be negative keep the loop from being vectorised.
    inside, mask = weights[first:], image.mask[v, origin + first :]
    for i in range(min(inside.size, mask.size)):
        inside[i] = share if mask[i] else np.float32(0.0)
    # The first channel last, since its inverse energies overwrite the weights.
    for c in range(channels - 1, -1, -1):
        for i in range(first, end, NUM_LANES):
            here, place = plane + 2 * c * padded + i, 3 * c * reach + i
            re = image.factor * load(planes, here)
            im = image.factor * load(planes, here + padded)
            store(row, place, re)
            store(row, place + reach, im)
            store(row, place + 2 * reach, load(weights, i) / (re * re + im * im + spread(_TINY)))
            # The next row, whose many short streams the processor does not foresee.
            prefetch(planes, here + to_next_row)
            prefetch(planes, here + to_next_row + padded)


@kernel
def _score(
    ring: Ring, here: int, there: int, search: Search, lines: tuple[ShortArray, ShortArray]
) -> None:
    """Write the scores, exact and with slack, of every second pixel of a row."""
    for first in range(0, ring.columns, NUM_LANES):
        for column in range(first, first + _APART):
            _score_two(ring, here + 2 * column, there + 2 * column, search)
            for k in range(2):
                _slacken(ring.line[k], (column + k * _APART) * ring.lanes, search, lines)


@kernel
def _score_two(ring: Ring, u: int, start: int, search: Search) -> None:
    """Write the scores of two pixels, `NUM_LANES` apart; all are 0 if they cannot be matched."""
    weights, line = ring.here[2 * ring.reach_here :], ring.line
    if weights[u] == 0.0 and weights[u + NUM_LANES] == 0.0:
        line[:] = 0.0
        return
    if search.table.size:
        _look_up(ring, u, start, search.table, line[0])
        _look_up(ring, u + NUM_LANES, start + NUM_LANES, search.table, line[1])
    else:
        _compare(ring, u, start)
    for i in range(NUM_LANES + search.num_shifts, NUM_LANES + ring.lanes):
        line[0, i] = line[1, i] = 0.0


@kernel
def _compare(ring: Ring, u: int, start: int) -> None:
    """Mean over scales and orientations of c cos(phase difference), for two pixels.

    ``Re(r conj r') / max(|r|^2, |r'|^2)`` is c cos, without computing an angle or a root. What the
    first pixel compares at one shift, the second does `NUM_LANES` shifts before: it is read once.
    """
    line, there, end = ring.line, ring.there, ring.lanes
    # The orientations of one scale at a time.
    for scale in range(len(there) // (9 * ring.reach)):
        one = _responses(ring, scale, u)
        two = _responses(ring, scale, u + NUM_LANES)
        k = 9 * scale * ring.reach + start
        _add(line[0], NUM_LANES, _alike(one, there, k, ring.reach), scale)
        for i in range(NUM_LANES, end, NUM_LANES):
            first = _alike(one, there, k + i, ring.reach)
            second = _alike(two, there, k + i, ring.reach)
            _add(line[0], NUM_LANES + i, first, scale)
            _add(line[1], i, second, scale)
        _add(line[1], end, _alike(two, there, k + end, ring.reach), scale)


@kernel
def _add(line: Floats, k: int, score: Lanes, scale: int) -> None:
    """Add to the scores of the scales before."""
    if scale:
        score += load(line, k)
    store(line, k, score)


@kernel
def _responses(ring: Ring, scale: int, u: int) -> tuple[_Response, _Response, _Response]:
    """Responses and inverse energies of one pixel in the orientations of a scale."""
    k, reach = 9 * scale * ring.reach_here + u, ring.reach_here
    return (
        _response(ring.here, k, reach),
        _response(ring.here, k + 3 * reach, reach),
        _response(ring.here, k + 6 * reach, reach),
    )


@kernel
def _response(here: Floats, k: int, reach: int) -> _Response:
    return repeat(here, k), repeat(here, k + reach), repeat(here, k + 2 * reach)


@kernel
def _alike(
    responses: tuple[_Response, _Response, _Response], there: Floats, k: int, reach: int
) -> Lanes:
    """c cos, summed over orientations, of a pixel and those of the other row from index k on."""
    score = _alike_in_one(responses[0], there, k, reach)
    score += _alike_in_one(responses[1], there, k + 3 * reach, reach)
    score += _alike_in_one(responses[2], there, k + 6 * reach, reach)
    return score


@kernel
def _alike_in_one(response: _Response, there: Floats, k: int, reach: int) -> Lanes:
    real, imag, inverse = response
    dot = real * load(there, k) + imag * load(there, k + reach)
    return dot * smaller(inverse, load(there, k + 2 * reach))


@kernel
def _look_up(ring: Ring, u: int, start: int, table: Floats, line: Floats) -> None:
    """Mean over scales and orientations of the table's similarity."""
    scales, num_c, num_cos = table.shape
    here = ring.here.reshape(-1, 3, ring.reach_here)
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
def _slacken(
    line: Floats, start: int, search: Search, lines: tuple[ShortArray, ShortArray]
) -> None:
    """Write the scores, clipped to >= 0, and the maximum of each and its neighbours.

    The neighbours are weighted by `SLACK`.
    """
    before, here, lanes = spread_short(0), _clipped(line, NUM_LANES), line.size - RIMS
    for i in range(0, lanes, NUM_SHORTS):
        # Scores that were just stored are slow to load from other positions.
        after = _clipped(line, NUM_LANES + i + NUM_SHORTS)
        beside = greater(short_earlier(before, here), short_later(here, after))
        store_shorts(lines[0], start + i, here)
        store_shorts(lines[1], start + i, greater(here, part(beside, spread_short(SLACK))))
        before, here = here, after
    for i in range(search.num_shifts, lanes):
        lines[1][start + i] = 0


@kernel
def _clipped(line: Floats, k: int) -> Shorts:
    first, second = (
        larger(load(line, k), spread(0.0)),
        larger(load(line, k + NUM_LANES), spread(0.0)),
    )
    return rounded(ONE * first, ONE * second)
