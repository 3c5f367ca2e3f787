"""Memory of the inner loops: where arrays begin, and what becomes of those that are freed."""

import numpy as np

from recon.stereo.kernels.simd import Floats

_LINE_BYTES = 64
"""Of the processor's memory: what lies across two lines is read twice."""
_LARGEST_KEPT = (32 << 20) - (8 << 10)
"""Bytes of the largest array that the C library ever learns to keep."""


def aligned_zeros(size: int) -> Floats:
    """(size,) zeros that begin where a line of the memory does."""
    spare = _LINE_BYTES // np.float32().nbytes
    buffer = np.zeros(size + spare, np.float32)
    address = buffer.__array_interface__["data"][0]
    first = -address % _LINE_BYTES // np.float32().nbytes
    return buffer[first : first + size]


def keep_what_is_freed() -> None:
    """Let the C library keep freed arrays for the next ones.

    glibc hands large arrays back to the system, and is given them again page by page, empty: up to
    a fifth of the time of a small pair, at every pair. It stops doing so for sizes up to the
    largest it has seen freed; nothing is touched here. This holds for the whole process: what
    others free of such sizes stays with it, too, for whoever asks next.
    """
    np.empty(_LARGEST_KEPT, np.uint8)


keep_what_is_freed()
