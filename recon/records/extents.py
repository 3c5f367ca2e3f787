"""Extents of solids: points whose hull is theirs."""

import numpy as np
from numpy.typing import NDArray

from recon.records.solids import (
    Box,
    Cone,
    Cylinder,
    Ellipsoid,
    Plane,
    Solid,
    Sphere,
    TruncatedCone,
)

Array = NDArray[np.float64]

AROUND = 48
"""Number of corners of a circle."""


def corners(solid: Solid) -> Array:
    """Points (N, 3) whose hull, seen from above, is that of the solid."""
    match solid:
        case Sphere():
            return solid.centre + solid.radius * _circle(np.array([0.0, 1.0, 0.0]))
        case Ellipsoid():
            # The rim seen from above: where the normal is horizontal.
            scaled = solid.axes.T * solid.radii
            upright = scaled[1] / np.linalg.norm(scaled[1])
            return solid.centre + _circle(upright) @ scaled.T
        case Cylinder():
            return rims(solid.point, solid.axis, solid.height, (solid.radius, solid.radius))
        case Cone():
            wide = float(solid.height * np.tan(solid.half_angle_rad))
            return rims(solid.apex, solid.axis, solid.height, (0.0, wide))
        case TruncatedCone():
            radii = solid.radius_bottom, solid.radius_top
            return rims(solid.point, solid.axis, solid.height, radii)
        case Box():
            signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
            return solid.centre + (signs * solid.sizes) @ solid.axes
        case Plane():
            return np.empty((0, 3))


def _circle(axis: Array) -> Array:
    """The unit circle (AROUND, 3) perpendicular to an axis."""
    across = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    ring: Array = np.outer(np.cos(angle), across) + np.outer(np.sin(angle), np.cross(axis, across))
    return ring


def rims(point: Array, axis: Array, height: float, radii: tuple[float, float]) -> Array:
    """Corners (2 * AROUND, 3) of the circles at both ends of an axis."""
    ring = _circle(axis)
    return np.vstack([point + radii[0] * ring, point + height * axis + radii[1] * ring])
