"""Directions perpendicular to an axis."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def across_axis(axis: Array) -> Array:
    """(2, 3) unit rows perpendicular to an axis (Duff et al. 2017, no branch near a pole)."""
    x, y, z = axis[0], axis[1], axis[2]
    sign = 1.0 if z >= 0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]])
