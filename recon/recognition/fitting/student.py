"""Student-t likelihood of residuals, compiled: the inner loops of every fit."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREES_OF_FREEDOM = 3.0
"""Of the Student-t noise: low enough that a tenth of gross outliers does not move a fit."""


@njit(cache=True)
def deviance(residuals: Array, sigma: float, share: Array, freedom: float) -> float:
    """Minus twice the log likelihood of residuals (N,), up to a constant."""
    tails = 0.0
    for i in range(len(residuals)):
        tails += share[i] * np.log1p((residuals[i] / sigma) ** 2 / freedom)
    size: float = 2.0 * len(residuals) * np.log(sigma)
    return (freedom + 1.0) * tails + size


@njit(cache=True)
def rescaled(
    residuals: Array, sigma: float, share: Array, floor: float, freedom: float, rounds: int
) -> float:
    """The scale of residuals (N,) after some rounds of expectation maximisation."""
    for _ in range(rounds):
        total = 0.0
        for i in range(len(residuals)):
            square = residuals[i] ** 2
            total += share[i] * (freedom + 1.0) / (freedom + square / sigma**2) * square
        sigma = max(floor, np.sqrt(total / len(residuals)))
    return sigma


@njit(cache=True)
def normal_equations(
    residuals: Array, jacobian: Array, sigma: float, share: Array, freedom: float
) -> tuple[Array, Array]:
    """``J^T W J`` (P, P) and ``J^T W r`` (P,) with the weights of Student-t noise."""
    size = jacobian.shape[1]
    normal, right = np.zeros((size, size)), np.zeros(size)
    for i in range(len(residuals)):
        weight = share[i] * (freedom + 1.0) / (freedom + (residuals[i] / sigma) ** 2)
        for j in range(size):
            weighted = weight * jacobian[i, j]
            right[j] += weighted * residuals[i]
            for k in range(j + 1):
                normal[j, k] += weighted * jacobian[i, k]
    for j in range(size):
        for k in range(j):
            normal[k, j] = normal[j, k]
    return normal, right


@njit(cache=True)
def damped_step(normal: Array, right: Array, damping: float) -> Array:
    """The Levenberg-Marquardt step (P,)."""
    size = len(right)
    damped, largest = normal.copy(), 0.0
    for j in range(size):
        largest = max(largest, normal[j, j])
    for j in range(size):
        damped[j, j] += damping * normal[j, j] + 1e-12 * largest + 1e-300
    step = np.zeros(size)
    step -= np.linalg.solve(damped, right)
    return step
