"""Uncertainty of depths beside breaks of the surface, where a matching window sees both sides."""

from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.surface.depth import DepthMap, Floats

_BREAK_PX = np.float32(1.0)
"""Bend of the disparity over three pixels, of which planes have none, that separates surfaces."""
_SIGMA_PX = 0.5
"""Sigma of a disparity beside a break, as the outline of the nearer surface is off by a pixel."""


def unsure_at_breaks(view: DepthMap) -> DepthMap:
    """The same depths, with a larger sigma at the pixels around breaks of the surface.

    Views from elsewhere, for which no outline passes there, then outweigh them.
    """
    beside = _beside_breaks(view.rig.disparity(view.depth).astype(np.float32))
    least = view.rig.depth_sigma(view.depth, _SIGMA_PX * beside)
    return replace(view, sigma=np.hypot(view.sigma, least).astype(np.float32))


@njit(cache=True, nogil=True, error_model="numpy")
def _beside_breaks(disparity: Floats) -> NDArray[np.bool_]:
    """(H, W) True at breaks along rows or columns, and at the eight pixels around each."""
    height, width = disparity.shape
    found = np.zeros((height, width), np.bool_)
    for v in range(height):
        for u in range(width):
            if _is_broken(disparity, v, u):
                found[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2] = True
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _is_broken(disparity: Floats, v: int, u: int) -> bool:
    height, width = disparity.shape
    here, bend = 2 * disparity[v, u], np.float32(0)
    if 0 < u < width - 1:
        along = abs(disparity[v, u - 1] + disparity[v, u + 1] - here)
        bend = along if along > bend else bend  # not where unknown
    if 0 < v < height - 1:
        across = abs(disparity[v - 1, u] + disparity[v + 1, u] - here)
        bend = across if across > bend else bend
    return bool(bend > _BREAK_PX)
