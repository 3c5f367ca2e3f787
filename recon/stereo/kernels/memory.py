"""Memory of the inner loops: alignment of arrays, and reuse of freed ones."""

import math
from collections import deque

import numpy as np

from recon.stereo.kernels.simd import Floats

_LINE_BYTES = 64
"""Size of a cache line: data across two lines is read twice."""
_LARGEST_KEPT = (32 << 20) - (8 << 10)
"""Bytes of the largest array that the C library can learn to keep."""
_SMALLEST_LENT, _LARGEST_LENT = 8 << 20, 128 << 20
"""Bytes of the arrays whose memory is kept by `reused_empty`."""


def aligned_zeros(size: int) -> Floats:
    """(size,) zeros aligned to a cache line."""
    zeros = aligned_empty(size)
    zeros[:] = 0.0
    return zeros


def aligned_empty(size: int) -> Floats:
    """(size,) numbers of any value, aligned to a cache line."""
    spare = _LINE_BYTES // np.float32().nbytes
    buffer = np.empty(size + spare, np.float32)
    address = buffer.__array_interface__["data"][0]
    first = -address % _LINE_BYTES // np.float32().nbytes
    return buffer[first : first + size]


def reused_empty(shape: tuple[int, ...]) -> Floats:
    """An array of any value, in the memory of an earlier one of the same size if that is free.

    For arrays that the C library does not keep, at least for threads but the first: their pages
    cost as much as writing them.
    """
    size = math.prod(shape)
    if not _SMALLEST_LENT < size * np.float32().nbytes <= _LARGEST_LENT:
        return np.empty(shape, np.float32)
    memory = _free.pop() if _free else None
    if memory is None or memory.size != size:
        memory = np.empty(size, np.float32)
    return np.asarray(_Lent(memory)).reshape(shape)


_free: deque[Floats] = deque(maxlen=4)
"""Memory of freed arrays: as many as the pairs of two threads use."""


class _Lent:
    """Memory that is free again when the last array in it is gone."""

    def __init__(self, memory: Floats) -> None:
        self.memory = memory
        self.__array_interface__ = memory.__array_interface__

    def __del__(self, free: deque[Floats] = _free) -> None:
        free.append(self.memory)


def keep_what_is_freed() -> None:
    """Let the C library keep freed arrays for the next ones.

    glibc returns large arrays to the system, and gets them back page by page, zeroed: up to a fifth
    of the time of a small pair, for every pair. It stops doing so for sizes up to the largest it
    has seen freed; no page is touched here. This affects the whole process: memory of such sizes
    freed by others is kept for reuse, too.
    """
    np.empty(_LARGEST_KEPT, np.uint8)


keep_what_is_freed()
