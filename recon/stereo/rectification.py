"""Exactness of a rig whose calibration is unknown, from the rows of its images.

Errors of a calibration act on rows and columns alike, but only those of the rows can be measured
without the depth: rows that agree exactly come from an exact rig, such as that of a renderer.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.stereo.kernels.simd import Floats, Integers
from recon.stereo.kernels.sorting import median

Array = NDArray[np.float64]
Pixels = tuple[Integers, ...]

_NUM_SAMPLES = 128
_FEWEST = 8
"""Minimum number of samples in a quarter of the image; the offset of fewer is unknown."""
_LARGEST_PHASE = 2.2
"""Radians; larger differences have wrapped or are meaningless."""
_LEAST_SPREAD = 0.02
"""Minimum determinant of the directions' information, relative to its squared trace: edges of one
direction do not determine both offsets."""
_MEDIAN_VARIANCE = np.pi / 2
"""Variance of the median of normal numbers, relative to that of their mean."""
_HALF_EXACT = 0.0004
"""Mean squared offset of the rows, squared pixels, at which a rig counts as half exact; recorded
pairs have ten times as much, rendered ones a tenth."""


def residual_of_rows(left: Floats, right: Floats, scales: Integers, pixels: Pixels) -> float:
    """Root mean square error of disparities that the offsets of the rows suggest, pixels.

    From 0, if the rows agree exactly, to that of typical recorded cameras, which also applies if
    the offsets are unknown.

    Parameters
    ----------
    left, right : (H, S, O, 2, W') float32
        See `Features.planes`.
    scales : (K,) int
    pixels : (u, v, u_right)
        Left column, row and right column (N,) of reliable matches, not at the border.
    """
    step = max(1, len(pixels[0]) // _NUM_SAMPLES)
    u, v, u_right = (np.ascontiguousarray(column[::step]) for column in pixels)
    offset, variance = _offsets(left, right, scales, (u, v, u_right))
    quarter = 2 * (v > left.shape[0] // 2) + (u > np.median(u)) if len(u) else u
    offsets_sq = [
        _offset_sq(offset[rows], variance[rows])
        for number in range(4)
        if (rows := np.isfinite(offset) & (quarter == number)).sum() >= _FEWEST
    ]
    if not offsets_sq:
        return TYPICAL_RESIDUAL_PX
    mean = float(np.mean(offsets_sq))
    return TYPICAL_RESIDUAL_PX * mean / (mean + _HALF_EXACT)


def _offset_sq(offset: Array, variance: Array) -> float:
    """Squared offset of some pairs; at least as much as is uncertain."""
    return max(median(offset) ** 2, _MEDIAN_VARIANCE * median(variance) / len(offset))


@njit(cache=True, error_model="numpy", nogil=True)
def _offsets(left: Floats, right: Floats, scales: Integers, pixels: Pixels) -> tuple[Array, Array]:
    """Offset of the rows at each pair and its variance; NaN where edges do not determine it."""
    u, v, u_right = pixels
    offset, variance = np.empty(v.size), np.empty(v.size)
    for i in range(v.size):
        offset[i], variance[i] = _offset(left, right, scales, (u[i], v[i], u_right[i]))
    return offset, variance


@njit(cache=True, error_model="numpy", nogil=True)
def _offset(
    left: Floats, right: Floats, scales: Integers, pixel: tuple[int, int, int]
) -> tuple[float, float]:
    """Solve for the offset along both axes by weighted least squares over all channels."""
    u, v, w = pixel
    xx = xy = yy = xe = ye = ee = 0.0
    count = 0
    for s in scales:
        for o in range(left.shape[2]):
            a, b = _at(left, v, s, o, u), _at(right, v, s, o, w)
            e = np.angle(b * np.conj(a))
            weight = min(abs(a), abs(b)) ** 2 if abs(e) < _LARGEST_PHASE else 0.0
            count += weight > 0
            x = _turn(left, (v, v), s, o, (u - 1, u + 1))
            x = 0.25 * (x + _turn(right, (v, v), s, o, (w - 1, w + 1)))
            y = _turn(left, (v - 1, v + 1), s, o, (u, u))
            y = 0.25 * (y + _turn(right, (v - 1, v + 1), s, o, (w, w)))
            xx, xy, yy = xx + weight * x * x, xy + weight * x * y, yy + weight * y * y
            xe, ye, ee = xe + weight * x * e, ye + weight * y * e, ee + weight * e * e
    determinant, trace = xx * yy - xy * xy, xx + yy
    if count <= 2 or not determinant > _LEAST_SPREAD * trace * trace:
        return np.nan, np.nan
    across = (yy * xe - xy * ye) / determinant
    down = (xx * ye - xy * xe) / determinant
    rest = max(ee - across * xe - down * ye, 0.0) / (count - 2)
    return down, rest * xx / determinant


@njit(cache=True, error_model="numpy", nogil=True)
def _at(planes: Floats, v: int, s: int, o: int, u: int) -> complex:
    return complex(planes[v, s, o, 0, u], planes[v, s, o, 1, u])


@njit(cache=True, error_model="numpy", nogil=True)
def _turn(planes: Floats, rows: tuple[int, int], s: int, o: int, columns: tuple[int, int]) -> float:
    """Change of the phase of a channel from one pixel to another."""
    before = _at(planes, rows[0], s, o, columns[0])
    after = _at(planes, rows[1], s, o, columns[1])
    return float(np.angle(after * np.conj(before)))
