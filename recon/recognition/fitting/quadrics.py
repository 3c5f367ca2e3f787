"""Algebraic quadrics: the thesis's fit (Eqs 46 to 58), and two that treat all directions alike.

``A x^2 + B y^2 + C z^2 + 2D xy + 2E xz + 2F yz + 2G x + 2H y + 2K z + L = 0``
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from recon.records import FitFailure

Array = NDArray[np.float64]

ALIKE = 1.3
"""Half axes whose ratio is smaller are equal; the thesis says "equal or very close"."""
MUCH_BIGGER = 2.0
"""A cylinder's third half axis over its second; the thesis says "very different"."""


def thesis_quadric(points: Array) -> Array:
    """Coefficients (10,) A, ..., L with A = 1, by the pseudo-inverse (Eqs 47 to 50).

    The points (N, 3) are taken as they are, neither centred nor scaled, as in the thesis.
    """
    design = _design(points)
    solution = np.linalg.pinv(design[:, 1:]) @ -design[:, 0]
    return np.concatenate([[1.0], solution])


def homogeneous_quadric(points: Array) -> Array:
    """Coefficients (10,) of unit length in centred, scaled coordinates, by singular values."""
    local, T = _normalised(points)
    coefficients = np.linalg.svd(_design(local), full_matrices=False)[2][-1]
    return _moved_back(coefficients, T)


def taubin_quadric(points: Array) -> Array:
    """Coefficients (10,) that make the mean squared gradient one (Taubin 1991)."""
    local, T = _normalised(points)
    design = _design(local)
    gradient = sum(part.T @ part for part in _gradients(local)) / len(local)
    scatter = design.T @ design / len(local)
    # The constant has no gradient; a little of the identity keeps the pencil regular.
    _, vectors = eigh(scatter, gradient + 1e-9 * np.eye(10))
    return _moved_back(vectors[:, 0], T)


def half_axes_sq(coefficients: Array) -> Array | FitFailure:
    """Squares a^2, b^2, c^2 (3,) of the half axes of a quadric (Eqs 51 to 58).

    Of a cylinder one is huge, of either sign; of a cone one is negative.
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


def _gradients(points: Array) -> list[Array]:
    x, y, z = 2.0 * points.T
    one, zero = np.full_like(x, 2.0), np.zeros_like(x)
    return [
        np.column_stack([x, zero, zero, y, z, zero, one, zero, zero, zero]),
        np.column_stack([zero, y, zero, x, zero, z, zero, one, zero, zero]),
        np.column_stack([zero, zero, z, zero, x, y, zero, zero, one, zero]),
    ]


def _normalised(points: Array) -> tuple[Array, Array]:
    """Points about their middle in units of their spread, and the (4, 4) that does it."""
    middle = points.mean(axis=0)
    scale = 1.0 / max(float(np.sqrt(points.var(axis=0).sum())), 1e-300)
    T = np.diag([scale, scale, scale, 1.0])
    T[:3, 3] = -scale * middle
    return (points - middle) * scale, T


def _moved_back(coefficients: Array, T: Array) -> Array:
    matrix = T.T @ _matrix(coefficients) @ T
    rows, columns = (
        np.array([0, 1, 2, 0, 0, 1, 0, 1, 2, 3]),
        np.array([0, 1, 2, 1, 2, 2, 3, 3, 3, 3]),
    )
    moved: Array = matrix[rows, columns]
    return moved


def _matrix(coefficients: Array) -> Array:
    A, B, C, D, E, F, G, H, K, L = coefficients
    return np.array([[A, D, E, G], [D, B, F, H], [E, F, C, K], [G, H, K, L]])
