"""Distances of points to single surfaces and their derivatives by a step, compiled.

Each function writes signed distances (N,) and derivatives (N, P). The numbers of a surface are the
fields of its state one after the other, as its model packs them.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.axes import across_axis

Array = NDArray[np.float64]


@njit(cache=True)
def to_plane(points: Array, numbers: Array, signed: Array, jacobian: Array) -> None:
    """Distances to a plane: point, normal; steps are a shift and two turns."""
    point, normal = numbers[:3], numbers[3:6]
    across = across_axis(normal)
    for i in range(len(points)):
        signed[i], jacobian[i, 1], jacobian[i, 2] = 0.0, 0.0, 0.0
        jacobian[i, 0] = -1.0
        for k in range(3):
            offset = points[i, k] - point[k]
            signed[i] += offset * normal[k]
            jacobian[i, 1] += offset * across[0, k]
            jacobian[i, 2] += offset * across[1, k]


@njit(cache=True)
def to_sphere(points: Array, numbers: Array, signed: Array, jacobian: Array) -> None:
    """Distances to a sphere: centre, radius."""
    for i in range(len(points)):
        square = 0.0
        for k in range(3):
            jacobian[i, k] = numbers[k] - points[i, k]
            square += jacobian[i, k] ** 2
        length = max(np.sqrt(square), 1e-300)
        for k in range(3):
            jacobian[i, k] /= length
        jacobian[i, 3] = -1.0
        signed[i] = length - numbers[3]


@njit(cache=True)
def to_ellipsoid(points: Array, numbers: Array, signed: Array, jacobian: Array) -> None:
    """First-order distances to an ellipsoid: centre, and the matrix that makes it the unit sphere.

    Steps are the centre and the matrix's six numbers, row by row.
    """
    matrix = numbers[3:12].copy().reshape(3, 3)
    offset, image, slope = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(points)):
        for k in range(3):
            offset[k] = points[i, k] - numbers[k]
        level = _image(offset, matrix, image)
        scale = 1.0 / max(_image(image, matrix, slope) / level, 1e-300)
        column = 3
        for j in range(3):
            jacobian[i, j] = -slope[j] / level * scale
            for k in range(j, 3):
                twice = image[j] * offset[k] + image[k] * offset[j]
                jacobian[i, column] = twice * (0.5 if j == k else 1.0) / level * scale
                column += 1
        signed[i] = (level - 1.0) * scale


@njit(cache=True)
def _image(offset: Array, matrix: Array, out: Array) -> float:
    """Write a vector times a symmetric matrix; its length, above 0."""
    square = 0.0
    for k in range(3):
        out[k] = offset[0] * matrix[0, k] + offset[1] * matrix[1, k] + offset[2] * matrix[2, k]
        square += out[k] ** 2
    length: float = max(np.sqrt(square), 1e-12)
    return length


@njit(cache=True)
def to_line(points: Array, numbers: Array, signed: Array, jacobian: Array) -> None:
    """Distances to a line round an axis: point, axis, offset, angle.

    Steps are the point and the axis (2 each), the offset, and of a cone the angle.
    """
    axis, offset, angle = numbers[3:6], numbers[6], numbers[7]
    across = across_axis(axis)
    c, s = np.cos(angle), np.sin(angle)
    for i in range(len(points)):
        t, x, y = 0.0, 0.0, 0.0
        for k in range(3):
            away = points[i, k] - numbers[k]
            t += away * axis[k]
            x += away * across[0, k]
            y += away * across[1, k]
        rho = max(np.hypot(x, y), 1e-300)
        turn = -(c * t + s * rho)
        jacobian[i, 0], jacobian[i, 1] = -c * x / rho, -c * y / rho
        jacobian[i, 2], jacobian[i, 3] = turn * x / rho, turn * y / rho
        jacobian[i, 4] = -1.0
        if jacobian.shape[1] == 6:
            jacobian[i, 5] = -s * rho - c * t
        signed[i] = c * rho - s * t - offset


@njit(cache=True)
def to_box(points: Array, numbers: Array, signed: Array, jacobian: Array) -> None:
    """Distances to the faces of a box, inside negative: centre, axes, edges.

    Steps are the centre, the turn and the half edges.
    """
    axes = numbers[3:12].copy().reshape(3, 3)
    local, side, pull = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(points)):
        face, length = 0, 0.0
        for k in range(3):
            local[k] = 0.0
            for j in range(3):
                local[k] += axes[k, j] * (points[i, j] - numbers[j])
            side[k] = -1.0 if local[k] < 0 else 1.0
            pull[k] = side[k] * local[k] - numbers[12 + k] / 2.0
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
