"""Filling of occlusion holes with the surface behind, and removal of specks."""

import cv2
import numpy as np
from numba import njit

from recon.stereo.kernels.simd import Floats

_FIXED_POINT = 8
"""Steps per pixel in the search for specks."""
_SPECK_STEP_PX = 2
"""Neighbours that differ by more belong to different patches."""
_AGREEMENT_PX = np.float32(1.5)
_NUM_AGREEING = 3
"""Minimum number of nearest known pixels in eight directions that agree with a filled value."""


def without_specks(disparity_px: Floats, smallest: int) -> Floats:
    """The disparities (H, W) without patches of fewer than `smallest` pixels."""
    known = np.isfinite(disparity_px)
    if not known.any():
        return disparity_px
    base = np.floor(disparity_px[known].min()) - 1
    steps = np.where(known, (disparity_px - base) * _FIXED_POINT, 0)
    patches = steps.astype(np.int16)
    cv2.filterSpeckles(patches, 0, smallest, _SPECK_STEP_PX * _FIXED_POINT)
    return np.where(patches > 0, disparity_px, np.float32(np.nan))


def filled_behind(disparity_px: Floats, widest_px: int) -> Floats:
    """The disparities (H, W), filled near known pixels of the same row.

    The farther of both sides is extended: areas visible to one camera only lie behind. It is
    accepted if enough of the surroundings agree.
    """
    found = disparity_px.copy()
    if widest_px:
        _fill_rows(disparity_px, _nearest(disparity_px), widest_px, found)
    return found


@njit(cache=True, nogil=True)
def _nearest(disparity: Floats) -> Floats:
    """(H, W, 6) nearest known values in the rows above and below: before, at and after."""
    height, width = disparity.shape
    near = np.full((height, width, 6), np.nan, np.float32)
    for row in range(1, height):
        _look_back(disparity[row - 1], near[row - 1], near[row], 0)
    for row in range(height - 2, -1, -1):
        _look_back(disparity[row + 1], near[row + 1], near[row], 3)
    return near


@njit(cache=True, nogil=True)
def _look_back(other: Floats, others_near: Floats, near: Floats, first: int) -> None:
    """Write the values that a row's pixels meet in another row, or those met there before."""
    width = other.size
    for u in range(width):
        for column in range(max(0, u - 1), min(width, u + 2)):
            k = first + column - u + 1
            known = np.isfinite(other[column])
            near[u, k] = other[column] if known else others_near[column, k]


@njit(cache=True, nogil=True)
def _fill_rows(disparity: Floats, near: Floats, widest: int, found: Floats) -> None:
    height, width = disparity.shape
    for v in range(height):
        last = -1
        for u in range(width + 1):
            if u < width and not np.isfinite(disparity[v, u]):
                continue
            if u - last > 1:
                _fill_gap(disparity[v], near[v], (last + 1, u), widest, found[v])
            last = u


@njit(cache=True, nogil=True)
def _fill_gap(row: Floats, near: Floats, gap: tuple[int, int], widest: int, found: Floats) -> None:
    """Fill the pixels of a gap that are near its farther end."""
    first, end = gap
    before = row[first - 1] if first > 0 else np.float32(np.nan)
    after = row[end] if end < row.size else np.float32(np.nan)
    from_left = not (after <= before)
    value = before if from_left and first > 0 else after
    for u in range(first, end):
        distance = u - first + 1 if value == before else end - u
        if distance <= widest and _support(before, after, near[u], value) >= _NUM_AGREEING:
            found[u] = value


@njit(cache=True, nogil=True)
def _support(before: float, after: float, near: Floats, value: float) -> int:
    """The number of known pixels around a hole that agree with a value."""
    count = int(abs(before - value) <= _AGREEMENT_PX) + int(abs(after - value) <= _AGREEMENT_PX)
    for k in range(near.size):
        count += int(abs(near[k] - value) <= _AGREEMENT_PX)
    return count
