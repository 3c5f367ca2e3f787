"""Shortest paths over the walkable cells: Dijkstra's algorithm with buckets, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.exploration.floor import Array, Mask

NO_CELL = -1
NUM_BUCKETS = 3
"""Buckets of one cell width each: steps are at least one and less than two cells long, so that
cells of one bucket cannot shorten each other's path, and none is put more than two buckets
ahead."""
DIAGONAL = 2.0**0.5
Cells = NDArray[np.int32]


def shortest(walkable: Mask, start: tuple[int, int]) -> tuple[Array, Cells]:
    """Shortest paths from a cell to all others over eight neighbours.

    Returns
    -------
    distance : (X, Z) float64
        In cells; infinite if there is no path.
    before : (X, Z, 2) int32
        The previous cell of each on its path; the first cell's is itself, NO_CELL if there is no
        path.
    """
    padded = np.pad(walkable, 1)
    width = padded.shape[1]
    around = np.array([1, width, width + 1, width - 1], np.int32)
    first = (start[0] + 1) * width + start[1] + 1
    waiting = np.empty((2, 8 * padded.size), np.int32)
    steps = np.concatenate([around, -around])
    distance, before = _spread(~padded.ravel(), first, steps, waiting[0], waiting[1])
    inner = (slice(1, -1), slice(1, -1))
    cells = np.stack(np.divmod(before, width), axis=-1).reshape(*padded.shape, 2) - 1
    return distance.reshape(padded.shape)[inner], cells[inner]


@njit(cache=True)
def _spread(
    settled: Mask, start: int, around: Cells, cell: Cells, after: Cells
) -> tuple[Array, Cells]:
    """Distance and previous cell (N,) of the unsettled cells of a grid with a settled border.

    The buckets are lists of waiting cells, linked by `after`; no cell is queued more often than it
    has neighbours.
    """
    distance = np.full(len(settled), np.inf)
    before = np.full(len(settled), NO_CELL, np.int32)
    heads = np.full(NUM_BUCKETS, NO_CELL, np.int32)
    distance[start], before[start], settled[start] = 0.0, start, False
    cell[0], after[0], heads[0] = start, NO_CELL, 0
    number, empty, bucket = 1, 0, 0
    while empty < NUM_BUCKETS:
        entry = heads[bucket % NUM_BUCKETS]
        if entry == NO_CELL:
            empty, bucket = empty + 1, bucket + 1
            continue
        empty, here = 0, cell[entry]
        heads[bucket % NUM_BUCKETS] = after[entry]
        for k in range(len(around) if not settled[here] else 0):
            there = here + around[k]
            length = distance[here] + (1.0 if k % 4 < 2 else DIAGONAL)
            if not settled[there] and length < distance[there]:
                distance[there], before[there] = length, here
                cell[number], after[number] = there, heads[int(length) % NUM_BUCKETS]
                heads[int(length) % NUM_BUCKETS] = number
                number += 1
        settled[here] = True
    return distance, before
