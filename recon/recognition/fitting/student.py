"""Student-t likelihood of residuals, compiled: the inner loops of every fit."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

REORDERED = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order, so that several terms are added at once; NaN and infinities stay as they
are."""
DEGREES_OF_FREEDOM = 3.0
"""Of the Student-t noise: low enough that a tenth of gross outliers does not move a fit."""


@njit(cache=True, error_model="numpy")
def deviance(residuals: Array, sigma: float, share: Array, freedom: float) -> float:
    """Minus twice the log likelihood of residuals (N,), up to a constant."""
    tails = 0.0
    for i in range(len(residuals)):
        tails += share[i] * np.log1p((residuals[i] / sigma) ** 2 / freedom)
    size: float = 2.0 * len(residuals) * np.log(sigma)
    return (freedom + 1.0) * tails + size


@njit(cache=True, error_model="numpy", fastmath=REORDERED)
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
    normal, right = np.empty((size, size)), np.empty(size)
    weight = _weights(residuals, sigma, share, freedom)
    for j in range(size):
        weighted = weight * jacobian[:, j]
        right[j] = _sum_of_products(weighted, residuals)
        for k in range(j + 1):
            normal[j, k] = normal[k, j] = _sum_of_products(weighted, jacobian[:, k])
    return normal, right


@njit(cache=True, error_model="numpy")
def _weights(residuals: Array, sigma: float, share: Array, freedom: float) -> Array:
    """Weights (N,) of residuals under Student-t noise."""
    weight = np.empty(len(residuals))
    for i in range(len(residuals)):
        ratio = residuals[i] / sigma
        weight[i] = share[i] * (freedom + 1.0) / (freedom + ratio * ratio)
    return weight


@njit(cache=True, fastmath=REORDERED)
def _sum_of_products(first: Array, second: Array) -> float:
    total = 0.0
    for i in range(len(first)):
        total += first[i] * second[i]
    return total


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
