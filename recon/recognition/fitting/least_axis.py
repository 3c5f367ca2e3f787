"""The direction in which points vary least, by formulas, compiled."""

import math

import numpy as np
from numba import njit

from recon.recognition.fitting.principal_axes import TINY, principal_axes

Vector = tuple[float, float, float]
Moments = tuple[float, float, float, float, float, float]
"""Of x with x, y and z, of y with y and z, and of z."""

PARALLEL = 1e-12
"""Square of the sine between two rows below which these are parallel."""


@njit(cache=True)
def least_axis(moments: Moments) -> Vector:
    """The direction of least variance: across the rows of the moments less their least value."""
    xx, xy, xz, yy, yz, zz = moments
    least = _least_variance(moments)
    first, second, third = (xx - least, xy, xz), (xy, yy - least, yz), (xz, yz, zz - least)
    normal, largest = (0.0, 0.0, 0.0), 0.0
    for across in (_across(first, second), _across(second, third), _across(third, first)):
        square = across[0] ** 2 + across[1] ** 2 + across[2] ** 2
        if square > largest:
            normal, largest = across, square
    scale = xx + yy + zz
    if largest <= PARALLEL * scale**4:
        axis = principal_axes(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))[1][0]
        return axis[0], axis[1], axis[2]
    length = math.sqrt(largest)
    return normal[0] / length, normal[1] / length, normal[2] / length


@njit(cache=True)
def _across(first: Vector, second: Vector) -> Vector:
    """The cross product."""
    (a, b, c), (d, e, f) = first, second
    return b * f - c * e, c * d - a * f, a * e - b * d


@njit(cache=True)
def _least_variance(moments: Moments) -> float:
    """The least eigenvalue of symmetric moments, by the trigonometric formula."""
    xx, xy, xz, yy, yz, zz = moments
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    square = (a * a + b * b + c * c) / 6.0 + (xy * xy + xz * xz + yz * yz) / 3.0
    spread = math.sqrt(max(square, TINY))
    a, b, c, xy, xz, yz = a / spread, b / spread, c / spread, xy / spread, xz / spread, yz / spread
    volume = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    angle = math.acos(min(max(volume / 2.0, -1.0), 1.0)) / 3.0
    least: float = mean + 2.0 * spread * math.cos(angle + 2.0 * math.pi / 3.0)
    return least
