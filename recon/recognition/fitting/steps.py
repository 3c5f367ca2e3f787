"""Surfaces after a step of their parameters, compiled: each returns the new numbers."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.axes import across_axis

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@njit(cache=True)
def moved_plane(numbers: Array, step: Array) -> Array:
    """A plane: the normal turns, the point goes along the old one."""
    moved = numbers.copy()
    moved[:3] += step[0] * numbers[3:6]
    _turn(moved, across_axis(numbers[3:6]), step[1:3])
    return moved


@njit(cache=True)
def moved_sphere(numbers: Array, step: Array) -> Array:
    """A sphere, whose radius stays positive."""
    moved = numbers + step
    moved[3] = abs(moved[3])
    return moved


@njit(cache=True)
def moved_ellipsoid(numbers: Array, step: Array) -> Array:
    """An ellipsoid, whose matrix stays symmetric."""
    moved = numbers.copy()
    moved[:3] += step[:3]
    column = 3
    for j in range(3):
        for k in range(j, 3):
            moved[3 + 3 * j + k] += step[column]
            if j != k:
                moved[3 + 3 * k + j] += step[column]
            column += 1
    return moved


@njit(cache=True)
def moved_line(numbers: Array, step: Array) -> Array:
    """A line round an axis; without a sixth number of the step its angle stays."""
    moved = numbers.copy()
    across = across_axis(numbers[3:6])
    for k in range(3):
        moved[k] += step[0] * across[0, k] + step[1] * across[1, k]
    _turn(moved, across, step[2:4])
    moved[6] += step[4]
    if len(step) == 6:
        moved[7] += step[5]
    return moved


@njit(cache=True)
def _turn(numbers: Array, across: Array, step: Array) -> None:
    """Turn the unit vector that follows a point."""
    square = 0.0
    for k in range(3):
        numbers[3 + k] += step[0] * across[0, k] + step[1] * across[1, k]
        square += numbers[3 + k] ** 2
    numbers[3:6] /= np.sqrt(square)


@njit(cache=True)
def moved_box(numbers: Array, step: Array) -> Array:
    """A box, whose axes stay unit and square to each other and whose edges do not turn."""
    moved = numbers.copy()
    moved[:3] += step[:3]
    x, y, z = step[3], step[4], step[5]
    turn = np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
    axes = turn @ numbers[3:12].copy().reshape(3, 3)
    for k in range(3):
        for j in range(k):
            axes[k] -= (axes[k] @ axes[j]) * axes[j]
        axes[k] /= np.sqrt(axes[k] @ axes[k])
    moved[3:12] = axes.ravel()
    for k in range(3):
        moved[12 + k] = max(moved[12 + k] + 2.0 * step[6 + k], 0.0)
    return moved


@njit(cache=True)
def moved_composite(numbers: Array, step: Array, num_parts: int) -> Array:
    """Upright parts: ends stay in order, radii positive; the ground, which is known, stays."""
    moved = numbers.copy()
    moved[:2] += step[:2]
    for k in range(num_parts):
        moved[3 + k] = max(moved[3 + k] + step[2 + k], moved[2 + k])
    for k in range(3 + num_parts, len(numbers)):
        moved[k] = abs(moved[k] + step[k - 1])
    return moved
