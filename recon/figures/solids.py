"""Fitted solids as closed meshes, to be drawn over their cells."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.geometry import pose
from recon.libraries import load_pyvista
from recon.records import Box, Cone, Cylinder, Ellipsoid, Plane, Solid, Sphere, TruncatedCone

Array = NDArray[np.float64]

AROUND = 48
"""Number of corners of a circle."""
PLANE_SIZE = 10.0
"""Edge of the square that represents a plane, world units."""


def mesh(solid: Solid) -> Any:
    """The surface of a solid as pyvista's PolyData, world; ends are closed."""
    pyvista = load_pyvista()
    match solid:
        case Sphere():
            return pyvista.Sphere(
                radius=solid.radius, center=solid.centre, theta_resolution=AROUND,
                phi_resolution=AROUND // 2,
            )  # fmt: skip
        case Ellipsoid():
            ball = pyvista.ParametricEllipsoid(*solid.radii)
            return ball.transform(pose(solid.axes.T, solid.centre), inplace=False)
        case Cylinder():
            return _frustum(solid.point, solid.axis, solid.height, solid.radius, solid.radius)
        case Cone():
            end = solid.height * np.tan(solid.half_angle_rad)
            return _frustum(solid.apex, solid.axis, solid.height, 0.0, float(end))
        case TruncatedCone():
            radii = solid.radius_bottom, solid.radius_top
            return _frustum(solid.point, solid.axis, solid.height, *radii)
        case Plane():
            size = {"i_size": PLANE_SIZE, "j_size": PLANE_SIZE}
            return pyvista.Plane(center=solid.point, direction=solid.normal, **size)
        case Box():
            cube = pyvista.Cube(
                x_length=solid.sizes[0], y_length=solid.sizes[1], z_length=solid.sizes[2]
            )
            return cube.transform(pose(solid.axes.T, solid.centre), inplace=False)


def triangles_of(solid: Solid) -> tuple[Array, NDArray[np.int32]]:
    """Vertices (V, 3) and triangles (T, 3) of a solid's closed surface."""
    surface = mesh(solid).triangulate()
    return np.asarray(surface.points, np.float64), surface.regular_faces.astype(np.int32)


def _frustum(point: Array, axis: Array, height: float, bottom: float, top: float) -> Any:
    """The lateral surface between two circles, and the circles."""
    pyvista = load_pyvista()
    across = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    ring = np.outer(np.cos(angle), across) + np.outer(np.sin(angle), np.cross(axis, across))
    corners = np.vstack([point + bottom * ring, point + height * axis + top * ring])
    here = np.arange(AROUND)
    then = (here + 1) % AROUND
    sides = np.column_stack([np.full(AROUND, 4), here, then, then + AROUND, here + AROUND])
    ends = [[AROUND, *here], [AROUND, *(here + AROUND)]]
    return pyvista.PolyData(corners, faces=np.concatenate([sides.ravel(), *ends]))
