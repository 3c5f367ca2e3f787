"""A search: the pixels of the other image that a pixel is compared with, and how."""

from typing import NamedTuple

import numpy as np

from recon.stereo.kernels.simd import Floats

C_COS = np.zeros((0, 0, 0), np.float32)
"""The table of the similarity ``c cos(phase difference)``."""


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
