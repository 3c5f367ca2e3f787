"""Scores of the last rows of a vertical strip of the image.

Only these are kept, in a buffer of constant size that mostly fits into the cache.
"""

from typing import NamedTuple

import numpy as np

from recon.stereo.kernels.memory import aligned_empty, aligned_zeros
from recon.stereo.kernels.shorts import NUM_SHORTS, ShortArray
from recon.stereo.kernels.simd import NUM_LANES, Floats, filled, kernel
from recon.stereo.matching.search import Search
from recon.stereo.matching.windows import SIDE_RADIUS

_RING_BYTES = 2 << 20
"""Maximum size of a ring."""
_NARROWEST = 64
"""Minimum columns of a strip, as it is computed with a margin on both sides."""

RIMS = NUM_LANES + NUM_SHORTS
"""Number of zeros before and after a line of scores."""
ONE = np.float32(32_000)
"""The score 1 in a ring: room is left in a short for what a sum of rounded parts may exceed it."""


class Ring(NamedTuple):
    """Scores of the last rows of a strip: for every second pixel of a row, one lane per shift."""

    scores: ShortArray
    """(2 * rows * columns * lanes,) exact scores, then those with slack for slanted surfaces.

    In units of 1 / `ONE`: their rounding is far below what separates two shifts, and twice as many
    scores fit into the cache, and are added up at once, as in single precision."""
    rows: int
    every: int
    """Step between image rows with scores; see `Search`."""
    columns: int
    lanes: int
    """Shifts, padded to multiples of `NUM_SHORTS`."""
    width: int
    """Image columns in a strip; with a margin of SIDE_RADIUS on both sides they are twice
    `columns`, which are whole lanes."""
    here: Floats
    """(C * 3 * reach_here,) responses and inverse energies of the strip's current row."""
    reach_here: int
    there: Floats
    """(C * 3 * reach,) the same for the row of the other image."""
    reach: int
    line: Floats
    """(2, lanes + RIMS) the scores of two pixels, between zeros."""


def make_ring(num_channels: int, search: Search, size: int) -> Ring:
    """An empty ring for the strips of `size` columns of an image."""
    lanes = filled(search.num_shifts, NUM_SHORTS)
    rows = 2 * SIDE_RADIUS // search.every + 1
    fitting = _RING_BYTES // (2 * rows * lanes * 2) * 2 - 2 * SIDE_RADIUS
    num_strips = -(-size // max(fitting, _NARROWEST))
    columns = filled(-(-size // (2 * num_strips)) + SIDE_RADIUS)
    reach_here = filled(2 * columns + NUM_LANES)
    reach = filled(2 * columns + 2 * NUM_LANES + lanes)
    return Ring(
        # Every line is written before it is read.
        scores=aligned_empty(rows * columns * lanes).view(np.int16),
        rows=rows,
        every=search.every,
        columns=columns,
        lanes=lanes,
        width=2 * (columns - SIDE_RADIUS),
        here=aligned_zeros(num_channels * 3 * reach_here),
        reach_here=reach_here,
        there=aligned_zeros(num_channels * 3 * reach),
        reach=reach,
        line=np.zeros((2, lanes + RIMS), np.float32),
    )


def steps(ring: Ring) -> tuple[int, int, int]:
    """Steps between scores: from column to column, from row to row, from exact to with slack."""
    line = ring.columns * ring.lanes
    return ring.lanes, line, ring.rows * line


@kernel
def ring_row(ring: Ring, v: int) -> int:
    """Row of the ring with the scores of a row of the image."""
    return v // ring.every % ring.rows


@kernel
def line_start(ring: Ring, v: int) -> int:
    """Start of the exact scores of a row of the image."""
    start: int = ring_row(ring, v) * ring.columns * ring.lanes
    return start


@kernel
def to_slack(ring: Ring) -> int:
    """Step from exact scores to those with slack."""
    return ring.rows * ring.columns * ring.lanes
