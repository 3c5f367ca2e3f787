"""Planes through drawn points and upright bars, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_SPAN = 1e-9
"""Minimum area of a triangle over the square of the points' extent: three points on a line span no
plane."""


@njit(cache=True)
def best_plane(
    points: Array, triples: Array, is_upright: bool, reach: float
) -> tuple[Array, Array]:
    """The plane through three points that has the most votes.

    Closer points count more: a plane across an edge is near many points but close to few.

    Parameters
    ----------
    points : (N, 3)
    triples : (D, 3, 3)
        Three points per draw.
    is_upright : bool
        Turn the planes upright.
    reach : float
        Distance up to which a point votes.

    Returns
    -------
    point, normal : (3,)
        The normal is 0 if no draw spans a plane.
    """
    extent = 0.0
    for axis in range(3):
        extent = max(extent, points[:, axis].max() - points[:, axis].min())
    best, point, normal = -1.0, np.zeros(3), np.zeros(3)
    for triple in triples:
        across = np.cross(triple[1] - triple[0], triple[2] - triple[0])
        if is_upright:
            across[1] = 0.0
        length = math.sqrt((across**2).sum())
        if length <= LEAST_SPAN * extent**2:
            continue
        across /= length
        total = _votes(points, triple[0], across, reach)
        if total > best:
            best, point, normal = total, triple[0], across
    return point, normal


@njit(cache=True)
def _votes(points: Array, point: Array, normal: Array, reach: float) -> float:
    """Sum of the votes of all points for a plane."""
    total = 0.0
    offset = point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]
    for i in range(len(points)):
        along = points[i, 0] * normal[0] + points[i, 1] * normal[1] + points[i, 2] * normal[2]
        total += max(1.0 - ((along - offset) / reach) ** 2, 0.0)
    return total


@njit(cache=True)
def upright_bar(points: Array) -> tuple[Array, float, float, float]:
    """Middle (x, z), median radius, lowest and highest point of an upright bar."""
    middle = np.array([points[:, 0].mean(), points[:, 2].mean()])
    rho = np.hypot(points[:, 0] - middle[0], points[:, 2] - middle[1])
    return middle, float(np.median(rho)), points[:, 1].min(), points[:, 1].max()
