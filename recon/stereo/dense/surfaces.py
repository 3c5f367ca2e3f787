"""Smoothing of disparities along surfaces, but not across their edges."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.simd import Floats, kernel_with_nan

Grey = NDArray[np.uint8]


_RADIUS_PX = 3
_STEP_PX = 1.0
"""Pixels that differ by more lie on another surface."""
_EDGE_LEVELS = np.float32(6.0)
"""Difference of grey levels at which a neighbour has half its weight."""
_FLATNESS = np.float32(0.5)
"""Squared pixels added to the window's moments: regularises planes through few pixels."""
_NUM_MOMENTS, _NUM_IN_ROW = 10, 6
"""Number of weighted sums of a window, of 1, y, x, yy, yx, xx, e, ye, xe, ee, and of a row."""


class Smoothed(NamedTuple):
    """Planes through the pixels of a small window that lie on one surface; NaN = unknown."""

    disparity_px: Floats
    """(H, W) disparity of the plane at the pixel."""
    spread_px: Floats
    """(H, W) root mean square distance of the window's pixels from the plane."""


def smooth(disparity_px: Floats, grey: Grey) -> Smoothed:
    """Replace every disparity by that of the plane through the similar pixels around it.

    Parameters
    ----------
    disparity_px : (H, W) float32
        NaN = unknown.
    grey : (H, W) uint8
    """
    found = Smoothed(*(np.full_like(disparity_px, np.nan) for _ in Smoothed._fields))
    beside = ((0, 0), (_RADIUS_PX, _RADIUS_PX))
    disparity = np.pad(disparity_px, beside, constant_values=np.nan)
    _fit_planes(disparity, np.pad(grey.astype(np.float32), beside), found)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_planes(disparity: Floats, grey: Floats, found: Smoothed) -> None:
    height, width = found.disparity_px.shape
    sums = np.empty((_NUM_MOMENTS, width), np.float32)
    parts = np.empty((_NUM_IN_ROW, width), np.float32)
    for v in range(height):
        sums[:] = 0
        middle = slice(_RADIUS_PX, _RADIUS_PX + width)
        for row in range(max(0, v - _RADIUS_PX), min(height, v + _RADIUS_PX + 1)):
            parts[:] = 0
            for x in range(-_RADIUS_PX, _RADIUS_PX + 1):
                there = slice(_RADIUS_PX + x, _RADIUS_PX + x + width)
                _add_pixel(
                    disparity[v, middle], grey[v, middle],
                    disparity[row, there], grey[row, there], np.float32(x), parts,
                )  # fmt: skip
            _add_row(parts, np.float32(row - v), sums)
        _solve(disparity[v, middle], sums, found.disparity_px[v], found.spread_px[v])


@kernel_with_nan
def _add_pixel(
    here: Floats, level: Floats, there: Floats, other: Floats, x: float, parts: Floats
) -> None:
    """Add the moments along a row, of the pixels x columns away: of 1, x, xx, e, xe, ee."""
    for u in range(here.size):
        e, unlike = there[u] - here[u], (other[u] - level[u]) / _EDGE_LEVELS
        near = abs(e) <= _STEP_PX  # false where unknown
        e = e if near else np.float32(0)
        w = (1 - e * e) / (1 + unlike * unlike) if near else np.float32(0)
        parts[0, u] += w
        parts[1, u] += w * x
        parts[2, u] += w * x * x
        parts[3, u] += w * e
        parts[4, u] += w * x * e
        parts[5, u] += w * e * e


@kernel_with_nan
def _add_row(parts: Floats, y: float, sums: Floats) -> None:
    """Add the moments of a row that is y rows away."""
    for u in range(sums.shape[1]):
        sums[0, u] += parts[0, u]
        sums[1, u] += y * parts[0, u]
        sums[2, u] += parts[1, u]
        sums[3, u] += y * y * parts[0, u]
        sums[4, u] += y * parts[1, u]
        sums[5, u] += parts[2, u]
        sums[6, u] += parts[3, u]
        sums[7, u] += y * parts[3, u]
        sums[8, u] += parts[4, u]
        sums[9, u] += parts[5, u]


@kernel_with_nan
def _solve(here: Floats, sums: Floats, disparity: Floats, spread: Floats) -> None:
    """Write the planes' values at the centre of their windows; unknown pixels stay NaN."""
    for u in range(here.size):
        one = 1 / sums[0, u]
        y, x, e = sums[1, u] * one, sums[2, u] * one, sums[6, u] * one
        yy, xx = sums[3, u] * one - y * y + _FLATNESS, sums[5, u] * one - x * x + _FLATNESS
        yx, ye = sums[4, u] * one - y * x, sums[7, u] * one - y * e
        xe, ee = sums[8, u] * one - x * e, sums[9, u] * one - e * e
        determinant = yy * xx - yx * yx
        down, across = (ye * xx - xe * yx) / determinant, (xe * yy - ye * yx) / determinant
        disparity[u] = here[u] + e - down * y - across * x
        rest = ee - down * ye - across * xe
        spread[u] = np.sqrt(np.float32(0) if rest < 0 else rest)


@njit(cache=True, nogil=True, error_model="numpy")
def median(disparity: Floats) -> Floats:
    """The median of the known pixels among the nine around each known one (H, W)."""
    height, width = disparity.shape
    found = np.full_like(disparity, np.nan)
    window = np.empty(9, np.float32)
    for v in range(height):
        for u in range(width):
            if np.isfinite(disparity[v, u]):
                found[v, u] = _middle(disparity, v, u, window)
    return found


@kernel_with_nan
def _middle(disparity: Floats, v: int, u: int, window: Floats) -> float:
    """The median of a window, by insertion sort."""
    height, width = disparity.shape
    count = 0
    for place in range(9):
        row, column = v + place // 3 - 1, u + place % 3 - 1
        if 0 <= row < height and 0 <= column < width and np.isfinite(disparity[row, column]):
            value, at = disparity[row, column], count
            while at > 0 and window[at - 1] > value:
                window[at] = window[at - 1]
                at -= 1
            window[at] = value
            count += 1
    middle: float = (window[(count - 1) // 2] + window[count // 2]) / 2
    return middle
