"""Aggregation over a support window: weighted sums of its members' scores, for every shift.

Scores and weights are shares in 16 bits, whose sums do not depend on their order.
"""

import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.shorts import (
    NUM_SHORTS,
    WHOLE,
    ShortArray,
    Shorts,
    first_equal,
    greater,
    greatest,
    lesser,
    load_shorts,
    part,
    spread_short,
    store_rounded,
    store_shorts,
)
from recon.stereo.kernels.simd import NUM_LANES, Floats, Integers, kernel, load, spread, total
from recon.stereo.matching.ring import Ring, ring_row
from recon.stereo.matching.windows import LIKENESS, Window

CLOSED, OPEN = np.int16(-WHOLE), np.int16(WHOLE - 1)
"""Highest possible support of a shift to a pixel that is not a candidate, and of others."""

_Eight = tuple[Shorts, Shorts, Shorts, Shorts, Shorts, Shorts, Shorts, Shorts]


@kernel
def weigh(
    image: NDArray[np.uint8],
    middle: int,
    window: Window,
    row: int,
    room: tuple[Floats, ShortArray],
) -> None:
    """Write the shares of the disc's members in their sum, higher for similar ones."""
    likeness = LIKENESS[255 - np.int64(image[middle]) :]
    pixel, weight = window.pixel[row], window.weight[row]
    weights, shares = room
    for k in range(weight.size):
        weights[k] = weight[k] * likeness[image[np.uint64(middle + pixel[k])]]
    together = spread(0.0)
    for k in range(0, weight.size, NUM_LANES):
        together += load(weights, k)
    share = np.float32(WHOLE - 1) / total(together)
    for k in range(0, weight.size, NUM_LANES):
        store_rounded(shares, k, share * load(weights, k))


@kernel
def locate(window: Window, row: int, ring: Ring, v: int, starts: Integers) -> None:
    """Write the starts of the scores of a window's members, relative to its centre's column."""
    below, offset = window.row[row], window.offset[row]
    here, line, size = ring_row(ring, v), ring.columns * ring.lanes, ring.rows
    for k in range(starts.size):
        place = here + below[k]
        # Of the last rows, those below the end of the ring are at its beginning.
        wrapped = np.int64(place < 0) - np.int64(place >= size)
        starts[k] = offset[k] + (here + wrapped * size) * line


@kernel
def add_up(
    scores: ShortArray, place: int, starts: Integers, shares: ShortArray, sums: ShortArray
) -> None:
    """Write the weighted sums of the members' scores for each shift, starting at `place`."""
    i = 0
    while i + 8 * NUM_SHORTS <= sums.size:
        _sum_eight(scores, place + i, starts, shares, sums[i:])
        i += 8 * NUM_SHORTS
    while i + 2 * NUM_SHORTS <= sums.size:
        _sum_two(scores, place + i, starts, shares, sums[i:])
        i += 2 * NUM_SHORTS
    if i < sums.size:
        _sum_one(scores, place + i, starts, shares, sums[i:])


@kernel
def _sum_eight(
    scores: ShortArray, place: int, starts: Integers, shares: ShortArray, sums: ShortArray
) -> None:
    # As many as there are registers for, since every pass reads starts and shares again.
    nothing = spread_short(0)
    eight = nothing, nothing, nothing, nothing, nothing, nothing, nothing, nothing
    for k in range(starts.size):
        share, start = spread_short(shares[k]), place + starts[np.uint64(k)]
        eight = _add_eight(eight, share, scores, start)
    for i in range(8):
        store_shorts(sums, i * NUM_SHORTS, eight[i])


@kernel
def _add_eight(sums: _Eight, share: Shorts, scores: ShortArray, k: int) -> _Eight:
    return (
        sums[0] + part(load_shorts(scores, k), share),
        sums[1] + part(load_shorts(scores, k + NUM_SHORTS), share),
        sums[2] + part(load_shorts(scores, k + 2 * NUM_SHORTS), share),
        sums[3] + part(load_shorts(scores, k + 3 * NUM_SHORTS), share),
        sums[4] + part(load_shorts(scores, k + 4 * NUM_SHORTS), share),
        sums[5] + part(load_shorts(scores, k + 5 * NUM_SHORTS), share),
        sums[6] + part(load_shorts(scores, k + 6 * NUM_SHORTS), share),
        sums[7] + part(load_shorts(scores, k + 7 * NUM_SHORTS), share),
    )


@kernel
def _sum_two(
    scores: ShortArray, place: int, starts: Integers, shares: ShortArray, sums: ShortArray
) -> None:
    a = b = spread_short(0)
    for k in range(starts.size):
        share, start = spread_short(shares[k]), place + starts[np.uint64(k)]
        a += part(load_shorts(scores, start), share)
        b += part(load_shorts(scores, start + NUM_SHORTS), share)
    store_shorts(sums, 0, a)
    store_shorts(sums, NUM_SHORTS, b)


@kernel
def _sum_one(
    scores: ShortArray, place: int, starts: Integers, shares: ShortArray, sums: ShortArray
) -> None:
    a = spread_short(0)
    for k in range(starts.size):
        start = place + starts[np.uint64(k)]
        a += part(load_shorts(scores, start), spread_short(shares[k]))
    store_shorts(sums, 0, a)


@kernel
def close(support: ShortArray, limits: ShortArray) -> int:
    """Close the shifts without a candidate; return the highest support."""
    highest = spread_short(CLOSED)
    for k in range(0, support.size, NUM_SHORTS):
        limited = lesser(load_shorts(support, k), load_shorts(limits, k))
        store_shorts(support, k, limited)
        highest = greater(highest, limited)
    return int(greatest(highest))


@kernel
def find(support: ShortArray, value: int) -> int:
    """The first shift with a value that one of them has."""
    k = 0
    place = first_equal(load_shorts(support, 0), value)
    while place == NUM_SHORTS:
        k += NUM_SHORTS
        place = first_equal(load_shorts(support, k), value)
    return k + int(place)


@kernel
def claim(support: ShortArray, claims: ShortArray) -> None:
    """Update the highest support of each pixel of the other row."""
    for k in range(0, support.size, NUM_SHORTS):
        store_shorts(claims, k, greater(load_shorts(support, k), load_shorts(claims, k)))


@kernel
def peak(support: ShortArray) -> int:
    """The highest support."""
    highest = load_shorts(support, 0)
    for k in range(NUM_SHORTS, support.size, NUM_SHORTS):
        highest = greater(highest, load_shorts(support, k))
    return int(greatest(highest))


@kernel
def forget(support: ShortArray, first: int, end: int) -> None:
    """Close the shifts from `first` to `end`."""
    for k in range(max(0, first), min(support.size, end)):
        support[k] = CLOSED
