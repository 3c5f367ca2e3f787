"""Distances of points to the faces of a box, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def to_box(points: Array, centre: Array, axes: Array, halves: Array) -> tuple[Array, Array]:
    """Signed distances (N,), negative inside; derivatives (N, 9) by centre, rotation, half edges.

    Parameters
    ----------
    points : (N, 3)
    centre : (3,)
    axes : (3, 3) unit rows
    halves : (3,) half edges
    """
    signed, jacobian = np.empty(len(points)), np.empty((len(points), 9))
    local, side, pull = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(points)):
        face, length = 0, 0.0
        for k in range(3):
            local[k] = 0.0
            for j in range(3):
                local[k] += axes[k, j] * (points[i, j] - centre[j])
            side[k] = -1.0 if local[k] < 0 else 1.0
            pull[k] = side[k] * local[k] - halves[k]
            face = k if pull[k] > pull[face] else face
            length += max(pull[k], 0.0) ** 2
        length = np.sqrt(length)
        signed[i] = length if length > 0 else pull[face]
        for k in range(3):
            nearest = 1.0 if k == face else 0.0
            pull[k] = max(pull[k], 0.0) / length if length > 0 else nearest
        x, y, z = side[0] * pull[0], side[1] * pull[1], side[2] * pull[2]
        for j in range(3):
            jacobian[i, j] = -(x * axes[0, j] + y * axes[1, j] + z * axes[2, j])
            jacobian[i, 6 + j] = -pull[j]
        jacobian[i, 3] = local[1] * z - local[2] * y
        jacobian[i, 4] = local[2] * x - local[0] * z
        jacobian[i, 5] = local[0] * y - local[1] * x
    return signed, jacobian
