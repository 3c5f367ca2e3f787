"""Algebraic quadrics: the thesis's fit (Eqs 46 to 58).

``A x^2 + B y^2 + C z^2 + 2D xy + 2E xz + 2F yz + 2G x + 2H y + 2K z + L = 0``
"""

import numpy as np
from numpy.typing import NDArray

from recon.records import FitFailure

Array = NDArray[np.float64]

ALIKE = 1.3
"""Half axes with a smaller ratio count as equal; the thesis says "equal or very close"."""
MUCH_BIGGER = 2.0
"""A cylinder's third half axis over its second; the thesis says "very different"."""


def thesis_quadric(points: Array) -> Array:
    """Coefficients (10,) A, ..., L with A = 1, by the pseudo-inverse (Eqs 47 to 50).

    The points (N, 3) are neither centred nor scaled, as in the thesis.
    """
    design = _design(points)
    solution = np.linalg.pinv(design[:, 1:]) @ -design[:, 0]
    return np.concatenate([[1.0], solution])


def half_axes_sq(coefficients: Array) -> Array | FitFailure:
    """Squares a^2, b^2, c^2 (3,) of the half axes of a quadric (Eqs 51 to 58).

    For a cylinder one is huge, of either sign; for a cone one is negative.
    """
    matrix = _matrix(coefficients)
    values, vectors = np.linalg.eigh(matrix[:3, :3])
    if np.abs(values).min() < 1e-12 * np.abs(values).max():
        return FitFailure("an eigenvalue of the quadric is zero")
    linear = matrix[:3, 3] @ vectors
    k = float((linear**2 / values).sum() - matrix[3, 3])
    squares: Array = k / values
    return squares


def quadric_shape(squares: Array) -> str | FitFailure:
    """Sphere, cylinder, cone or ellipsoid by the thesis's rule on a^2, b^2, c^2."""
    if (squares <= 0).all():
        return FitFailure("no half axis of the quadric is real")
    if (squares < 0).any():
        return "cone"
    small, middle, large = np.sqrt(np.sort(squares))
    if large < ALIKE * small:
        return "sphere"
    if large > MUCH_BIGGER * middle and middle < ALIKE * small:
        return "cylinder"
    return "ellipsoid"


def _design(points: Array) -> Array:
    x, y, z = points.T
    one = np.ones_like(x)
    columns = [x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z, one]
    return np.column_stack(columns)


def _matrix(coefficients: Array) -> Array:
    A, B, C, D, E, F, G, H, K, L = coefficients
    return np.array([[A, D, E, G], [D, B, F, H], [E, F, C, K], [G, H, K, L]])
