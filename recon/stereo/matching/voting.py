"""Aggregation over a support window: weighted sums of its members' scores, for every shift."""

import numpy as np
from numpy.typing import NDArray

from recon.stereo.kernels.halves import Halves, load_halves
from recon.stereo.kernels.simd import (
    NUM_LANES,
    Floats,
    Integers,
    Lanes,
    kernel,
    larger,
    largest,
    load,
    repeat,
    spread,
    store,
    total,
)
from recon.stereo.matching.ring import Ring, ring_row
from recon.stereo.matching.windows import LIKENESS, Window

CLOSED = np.float32(-1e9)
"""Support of a shift to a pixel that is not a candidate."""

_Four = tuple[Lanes, Lanes, Lanes, Lanes]
_Six = tuple[Lanes, Lanes, Lanes, Lanes, Lanes, Lanes]


@kernel
def weigh(
    image: NDArray[np.uint8], middle: int, window: Window, row: int, weights: Floats
) -> float:
    """Write the weights of the disc's members, higher for similar ones; return 1 / their sum."""
    here = np.int64(image[middle])
    pixel, weight = window.pixel[row], window.weight[row]
    for k in range(weight.size):
        there = np.int64(image[np.uint64(middle + pixel[k])])
        weights[k] = weight[k] * LIKENESS[np.uint64(abs(there - here))]
    together = spread(0.0)
    for k in range(0, weight.size, NUM_LANES):
        together += load(weights, k)
    return float(np.float32(1.0) / (total(together) + np.float32(1e-6)))


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
def add_up(scores: Halves, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    """Write the weighted sums of the members' scores for each shift, starting at `place`."""
    i = 0
    while i + 6 * NUM_LANES <= sums.size:
        _sum_six(scores, place + i, starts, weights, sums[i:])
        i += 6 * NUM_LANES
    if i + 4 * NUM_LANES <= sums.size:
        _sum_four(scores, place + i, starts, weights, sums[i:])
        i += 4 * NUM_LANES
    while i < sums.size:
        _sum_two(scores, place + i, starts, weights, sums[i:])
        i += 2 * NUM_LANES


@kernel
def _sum_six(scores: Halves, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    # As many as there are registers for, since every pass reads the starts again.
    nothing = spread(0.0)
    even = odd = nothing, nothing, nothing, nothing, nothing, nothing
    for k in range(0, starts.size, 2):
        even = _add_six(even, repeat(weights, k), scores, place + starts[np.uint64(k)])
        odd = _add_six(odd, repeat(weights, k + 1), scores, place + starts[np.uint64(k + 1)])
    for i in range(6):
        store(sums, i * NUM_LANES, even[i] + odd[i])


@kernel
def _sum_four(scores: Halves, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    nothing = spread(0.0)
    even = odd = nothing, nothing, nothing, nothing
    for k in range(0, starts.size, 2):
        even = _add_four(even, repeat(weights, k), scores, place + starts[np.uint64(k)])
        odd = _add_four(odd, repeat(weights, k + 1), scores, place + starts[np.uint64(k + 1)])
    for i in range(4):
        store(sums, i * NUM_LANES, even[i] + odd[i])


@kernel
def _add_four(sums: _Four, weight: Lanes, scores: Halves, k: int) -> _Four:
    return (
        sums[0] + weight * load_halves(scores, k),
        sums[1] + weight * load_halves(scores, k + NUM_LANES),
        sums[2] + weight * load_halves(scores, k + 2 * NUM_LANES),
        sums[3] + weight * load_halves(scores, k + 3 * NUM_LANES),
    )


@kernel
def _add_six(sums: _Six, weight: Lanes, scores: Halves, k: int) -> _Six:
    return (
        sums[0] + weight * load_halves(scores, k),
        sums[1] + weight * load_halves(scores, k + NUM_LANES),
        sums[2] + weight * load_halves(scores, k + 2 * NUM_LANES),
        sums[3] + weight * load_halves(scores, k + 3 * NUM_LANES),
        sums[4] + weight * load_halves(scores, k + 4 * NUM_LANES),
        sums[5] + weight * load_halves(scores, k + 5 * NUM_LANES),
    )


@kernel
def _sum_two(scores: Halves, place: int, starts: Integers, weights: Floats, sums: Floats) -> None:
    # Two independent sums, since a single one would stall on its own latency.
    a = b = c = d = spread(0.0)
    for k in range(0, starts.size, 2):
        weight, start = repeat(weights, k), place + starts[np.uint64(k)]
        a += weight * load_halves(scores, start)
        b += weight * load_halves(scores, start + NUM_LANES)
        weight, start = repeat(weights, k + 1), place + starts[np.uint64(k + 1)]
        c += weight * load_halves(scores, start)
        d += weight * load_halves(scores, start + NUM_LANES)
    store(sums, 0, a + c)
    store(sums, NUM_LANES, b + d)


@kernel
def close(support: Floats, share: float, closed: Floats) -> float:
    """Turn sums into means, and close the shifts without a candidate; return the highest."""
    highest = spread(CLOSED)
    for k in range(0, support.size, NUM_LANES):
        mean = share * load(support, k) + load(closed, k)
        store(support, k, mean)
        highest = larger(highest, mean)
    return float(largest(highest))


@kernel
def claim(support: Floats, claims: Floats) -> None:
    """Update the highest support of each pixel of the other row."""
    for k in range(0, support.size, NUM_LANES):
        store(claims, k, larger(load(support, k), load(claims, k)))


@kernel
def peak(support: Floats) -> float:
    """The highest support."""
    highest = load(support, 0)
    for k in range(NUM_LANES, support.size, NUM_LANES):
        highest = larger(highest, load(support, k))
    return float(largest(highest))


@kernel
def forget(support: Floats, first: int, end: int) -> None:
    """Close the shifts from `first` to `end`."""
    for k in range(max(0, first), min(support.size, end)):
        support[k] = CLOSED
