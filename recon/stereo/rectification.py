"""How far the rows of a rectified pair differ, from the phases of its own matches.

Errors of a calibration act on rows and columns alike, but only those of the rows can be measured
without the depth.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.stereo.kernels.simd import Floats, Integers

Array = NDArray[np.float64]
Pixels = tuple[Integers, Integers, Integers]

_NUM_SAMPLES = 96
_FEWEST = 30
"""Minimum number of samples; of fewer, the rows' offset is unknown."""
_LARGEST_PHASE = 2.2
"""Radians; larger differences have wrapped or are meaningless."""
_LEAST_SPREAD = 0.05
"""Minimum determinant of the directions' information, relative to its squared trace: edges of one
direction do not determine both offsets."""
_OF_DISAGREEMENT = 1.2
"""Squared offset that the disagreement of the channels explains, relative to the latter."""
_NUM_UNKNOWNS = 2
_OF_MEDIAN = 1.4826
"""Standard deviation of a normal distribution, relative to its median absolute value."""


def row_residual_sq(
    left: Floats, right: Floats, scales: Integers, pixels: Pixels, last_column: int
) -> float:
    """Mean squared offset of the rows of two images, squared pixels, less that of their noise.

    Parameters
    ----------
    left, right : (H, S, O, 2, W') float32
        See `Features.planes`.
    scales : (K,) int
    pixels : tuple of (N,) int
        Left column, row and right column of reliable matches.
    last_column : int
        Of the images.

    Returns
    -------
    float
        Infinite if unknown.
    """
    some = tuple(column[:: max(1, len(column) // _NUM_SAMPLES)] for column in pixels)
    offset, disagreement = _offsets(left, right, scales, some, last_column)
    known = np.isfinite(offset)
    if known.sum() < _FEWEST:
        return np.inf
    offset, middle = offset[known], np.median(offset[known])
    spread = _OF_MEDIAN * np.median(np.abs(offset - middle))
    own = _OF_DISAGREEMENT * np.median(disagreement[known])
    return max(0.0, float(middle**2 + spread**2 - own))


@njit(cache=True, error_model="numpy", nogil=True)
def _offsets(
    left: Floats, right: Floats, scales: Integers, pixels: Pixels, last_column: int
) -> tuple[Array, Array]:
    """Row offset of each pair and mean squared phase left unexplained, in pixels; NaN = unknown."""
    u, v, u_right = pixels
    offset, disagreement = np.full(v.size, np.nan), np.full(v.size, np.nan)
    last_row = left.shape[0] - 1
    for i in range(v.size):
        first, last = min(u[i], u_right[i]), max(u[i], u_right[i])
        if 0 < v[i] < last_row and first > 0 and last < last_column:
            offset[i], disagreement[i] = _offset(left, right, scales, (u[i], v[i], u_right[i]))
    return offset, disagreement


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
    if count <= _NUM_UNKNOWNS or not determinant > _LEAST_SPREAD * trace * trace:
        return np.nan, np.nan
    across = (yy * xe - xy * ye) / determinant
    down = (xx * ye - xy * xe) / determinant
    rest = max(ee - across * xe - down * ye, 0.0) * count / (count - _NUM_UNKNOWNS)
    return down, rest / trace


@njit(cache=True, error_model="numpy", nogil=True)
def _at(planes: Floats, v: int, s: int, o: int, u: int) -> complex:
    return complex(planes[v, s, o, 0, u], planes[v, s, o, 1, u])


@njit(cache=True, error_model="numpy", nogil=True)
def _turn(planes: Floats, rows: tuple[int, int], s: int, o: int, columns: tuple[int, int]) -> float:
    """Change of the phase of a channel from one pixel to another."""
    before = _at(planes, rows[0], s, o, columns[0])
    after = _at(planes, rows[1], s, o, columns[1])
    return float(np.angle(after * np.conj(before)))
