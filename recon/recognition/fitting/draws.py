"""Solids through a few points with normals each, and the votes of all points, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import Cone, Cylinder, Plane, Solid, Sphere

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

Drawn = tuple[Array, Array, float]
"""Point, direction, and radius or half angle."""
PLANE, SPHERE, CYLINDER, CONE = range(4)
"""Columns of the votes."""
LEAST_SINE, LEAST_VOLUME = 1e-2, 1e-3
"""Of the normals of two and of three points: those of nearly one direction show no solid."""
REACH = 4.0
"""Largest distance of a cone's tip from its points, and length of drawn solids, in sizes of the
scene."""


@njit(cache=True)
def ranked_neighbours(
    points: Array, firsts: NDArray[np.int64], ranks: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Rows (D, 3) of two neighbours of points, of given ranks by distance, and of the points.

    Parameters
    ----------
    points : (N, 3)
    firsts : (D,)
    ranks : (D, 2)
        0 is the point itself.
    """
    rows = np.empty((len(firsts), 3), dtype=np.int64)
    squares = np.empty(len(points))
    for d in range(len(firsts)):
        for i in range(len(points)):
            squares[i] = 0.0
            for axis in range(3):
                squares[i] += (points[i, axis] - points[firsts[d], axis]) ** 2
        for k in range(2):
            rows[d, k] = np.argmax(squares == np.partition(squares, ranks[d, k])[ranks[d, k]])
        rows[d, 2] = firsts[d]
    return rows


@njit(cache=True)
def drawn(points: Array, normals: Array, size: float) -> tuple[Array, Array, Array]:
    """Solids through three points each.

    Parameters
    ----------
    points, normals : (D, 3, 3)
    size : float
        Of the scene.

    Returns
    -------
    places, axes : (D, 4, 3)
        A point and a direction of the plane, sphere, cylinder and cone.
    numbers : (D, 4)
        Radius, of a cone its half angle; NaN where the points show no such solid.
    """
    places, axes = np.zeros((len(points), 4, 3)), np.zeros((len(points), 4, 3))
    numbers = np.full((len(points), 4), np.nan)
    for d in range(len(points)):
        places[d, PLANE], axes[d, PLANE], numbers[d, PLANE] = points[d, 2], normals[d, 2], 0.0
        _round(points[d], normals[d], size, places[d], axes[d], numbers[d])
        _cone(points[d], normals[d], size, places[d], axes[d], numbers[d])
    return places, axes, numbers


@njit(cache=True)
def _round(
    points: Array, normals: Array, size: float, places: Array, axes: Array, numbers: Array
) -> None:
    """Write the sphere and the cylinder across whose surface two normals stand."""
    axis = np.cross(normals[0], normals[1])
    sine = np.sqrt(_dot(axis, axis))
    if sine < LEAST_SINE:
        return
    axis /= sine
    # Feet of the common perpendicular of the two normal lines.
    offset = points[1] - points[0]
    first = points[0] + _dot(np.cross(offset, normals[1]), axis) / sine * normals[0]
    second = points[1] + _dot(np.cross(offset, normals[0]), axis) / sine * normals[1]
    centre = (first + second) / 2.0
    radius = (_length(points[0] - centre) + _length(points[1] - centre)) / 2.0
    if radius < size:
        places[SPHERE], numbers[SPHERE] = centre, radius
    radius = _length(points[0] - first)
    if radius < size:
        places[CYLINDER], axes[CYLINDER], numbers[CYLINDER] = first, axis, radius


@njit(cache=True)
def _cone(
    points: Array, normals: Array, size: float, places: Array, axes: Array, numbers: Array
) -> None:
    """Write the cone that three tangent planes touch."""
    if abs(np.linalg.det(normals)) < LEAST_VOLUME:
        return
    offsets = np.array([_dot(points[k], normals[k]) for k in range(3)])
    apex = np.linalg.solve(normals, offsets)
    rays = points - apex
    for k in range(3):
        length = _length(rays[k])
        if length < 1e-9 * size or length > REACH * size:
            return
        rays[k] /= length
    axis = np.cross(rays[1] - rays[0], rays[2] - rays[0])
    norm = _length(axis)
    if norm < 1e-9:
        return
    axis *= np.sign(_dot(axis, rays[0])) / norm
    angle = 0.0
    for k in range(3):
        angle += np.arccos(min(max(_dot(rays[k], axis), -1.0), 1.0)) / 3.0
    places[CONE], axes[CONE], numbers[CONE] = apex, axis, angle


@njit(cache=True)
def _dot(first: Array, second: Array) -> float:
    product: float = first[0] * second[0] + first[1] * second[1] + first[2] * second[2]
    return product


@njit(cache=True)
def _length(vector: Array) -> float:
    length: float = np.sqrt(_dot(vector, vector))
    return length


@njit(cache=True)
def votes(voters: Array, places: Array, axes: Array, numbers: Array, tolerance: float) -> Numbers:
    """Voters (N, 3) that lie on each of the drawn solids (D, 4); none on what is not one."""
    counts = np.zeros(numbers.shape, dtype=np.int64)
    for d in range(len(numbers)):
        for shape in range(4):
            if not np.isnan(numbers[d, shape]):
                drawn = places[d, shape], axes[d, shape], numbers[d, shape]
                counts[d, shape] = _votes(voters, drawn, shape, tolerance)
    return counts


@njit(cache=True)
def _votes(voters: Array, drawn: Drawn, shape: int, tolerance: float) -> int:
    """Voters (N, 3) that lie on a solid."""
    (place, axis, number), count = drawn, 0
    lean = math.cos(number), math.sin(number)
    for i in range(len(voters)):
        x, y, z = voters[i, 0] - place[0], voters[i, 1] - place[1], voters[i, 2] - place[2]
        along = x * axis[0] + y * axis[1] + z * axis[2]
        count += _away(along, x * x + y * y + z * z, number, lean, shape) < tolerance
    return count


@njit(cache=True)
def _away(
    along: float, square: float, number: float, lean: tuple[float, float], shape: int
) -> float:
    """Distance of a position to a solid.

    Parameters
    ----------
    along : float
        Position along the axis, from the solid's place.
    square : float
        Squared distance from the place.
    lean : tuple of float
        Cosine and sine of a cone's half angle.
    """
    away: float
    if shape == PLANE:
        away = abs(along)
    elif shape == SPHERE:
        away = abs(math.sqrt(square) - number)
    elif shape == CYLINDER:
        away = abs(math.sqrt(max(square - along * along, 0.0)) - number)
    else:
        away = _from_cone(along, math.sqrt(max(square - along * along, 0.0)), lean)
    return away


@njit(cache=True)
def _from_cone(along: float, rho: float, lean: tuple[float, float]) -> float:
    """Distance to a cone of a position along its axis and away from it."""
    c, s = lean
    before_tip = c * along + s * rho <= 0
    away: float = math.sqrt(along * along + rho * rho) if before_tip else abs(c * rho - s * along)
    return away


def solid(shape: int, place: Array, axis: Array, number: float, size: float) -> Solid:
    """One drawn solid, as long as it can be."""
    if shape == PLANE:
        return Plane(point=place, normal=axis)
    if shape == SPHERE:
        return Sphere(centre=place, radius=number)
    if shape == CYLINDER:
        foot = place - REACH / 2.0 * size * axis
        return Cylinder(point=foot, axis=axis, radius=number, height=REACH * size)
    return Cone(apex=place, axis=axis, half_angle_rad=number, height=REACH * size)
