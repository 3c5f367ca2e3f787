"""The one inner loop of filters and support: a weighted sum of stretches of one buffer."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Integers = NDArray[np.int64]

UNROLL = 4
"""Stretches are added four at a time; lists are filled up with weight 0."""
FAST = {"contract", "nsz", "nnan"}
"""What the compiler may do to sums: nothing that changes from run to run."""

kernel = njit(cache=True, fastmath=FAST, error_model="numpy", _nrt=False)
"""Compiles loops that allocate nothing. References to views are not counted in them: each count
would be a locked instruction, and a fifth of the time of a whole pair."""


def filled(size: int) -> int:
    """`size` brought up to a multiple of `UNROLL`."""
    return -(-size // UNROLL) * UNROLL


@kernel
def weighted_sum(buffer: Floats, starts: Integers, weights: Floats, total: Floats) -> None:
    """Write to `total` the sum of `weights[k] * buffer[starts[k] + i]` over k, for every i."""
    total[:] = 0.0
    for k in range(0, weights.size, UNROLL):
        # Unsigned, as an index that might be negative keeps the loop from being vectorised.
        a, b = np.uint64(starts[k]), np.uint64(starts[k + 1])
        c, d = np.uint64(starts[k + 2]), np.uint64(starts[k + 3])
        p, q, r, s = weights[k], weights[k + 1], weights[k + 2], weights[k + 3]
        for i in range(np.uint64(total.size)):
            total[i] += (
                p * buffer[a + i] + q * buffer[b + i] + r * buffer[c + i] + s * buffer[d + i]
            )
