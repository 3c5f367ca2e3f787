"""Footprints of solids and objects: outlines in x and z, counter-clockwise in (x, -z)."""

import numpy as np
from numpy.typing import NDArray

from recon.figures.partition import cells_of
from recon.records import (
    Box,
    Cone,
    Cylinder,
    Ellipsoid,
    FoundObject,
    Plane,
    Solid,
    Sphere,
    TruncatedCone,
    Voxels,
)

Array = NDArray[np.float64]

AROUND = 48
"""Number of corners of a circle."""
MAX_EXTENT = 2.0
"""Largest extent of a solid relative to its object, of which half may not have been seen."""
GRID, TINY = 1 << 20, 1e-12
"""Steps of the grid on which hulls are found, along an outline; least size of an outline."""


def of_object(found: FoundObject, voxels: Voxels) -> Array:
    """Outline (N, 2) in x, z: of the solids, else of the box, else of the cells."""
    outlines = [of_solid(part.solid) for part in found.parts if is_near(part.solid, found)]
    corners = [outline for outline in outlines if len(outline)]
    if corners:
        return _hull(np.vstack(corners))
    if found.box is not None:
        box = found.box
        return of_solid(Box(centre=box.centre, axes=box.axes, sizes=box.sizes))
    cells = cells_of(voxels, found)
    if len(cells) < 3:
        return rectangle(found.centre[[0, 2]], np.eye(2), found.size[[0, 2]])
    return least_rectangle(cells.means[:, [0, 2]])


def is_near(solid: Solid, found: FoundObject) -> bool:
    """True unless a solid extends far beyond its object, as one that fits a nearly flat piece."""
    corners = _corners(solid)
    return not len(corners) or bool(
        np.linalg.norm(np.ptp(corners, axis=0)) <= MAX_EXTENT * np.linalg.norm(found.size)
    )


def of_solid(solid: Solid) -> Array:
    """Outline (N, 2) in x, z of a solid seen from above; (0, 2) for a plane, which has none."""
    return _hull(_corners(solid)[:, [0, 2]])


def rectangle(centre: Array, axes: Array, sizes: Array) -> Array:
    """Corners (4, 2) of a rectangle with `sizes` (2,) along the rows of `axes` (2, 2)."""
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2.0
    return _hull(centre + (signs * sizes) @ axes)


def least_rectangle(points: Array) -> Array:
    """Corners (4, 2) of the smallest rectangle around points (N, 2), along a side of their hull."""
    hull = _hull(points)
    sides = np.roll(hull, -1, axis=0) - hull
    best, least = rectangle(points.mean(axis=0), np.eye(2), np.ptp(points, axis=0)), np.inf
    for side in sides[np.linalg.norm(sides, axis=1) > 0]:
        along = side / np.linalg.norm(side)
        axes = np.array([along, [-along[1], along[0]]])
        turned = hull @ axes.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        if np.prod(high - low) < least:
            least = float(np.prod(high - low))
            best = rectangle((low + high) / 2.0 @ axes, axes, high - low)
    return best


def _corners(solid: Solid) -> Array:
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


def _hull(points: Array) -> Array:
    """Corners of the convex hull of points (N, 2), in map order; all points if it has no area.

    It is that of points on a grid, and begins at its corner of least z, then least x: the last
    digit of a coordinate decides neither, and thus not where its dashes begin.
    """
    from cv2 import convexHull

    if not len(points):
        return points
    size = max(float(np.ptp(points, axis=0).max()), TINY)
    grid = np.rint((points - points.min(axis=0)) * (GRID / size)).astype(np.int32)
    # Counter-clockwise in (x, z) is clockwise in (x, -z), which maps draw.
    corners = convexHull(grid, clockwise=True, returnPoints=False).ravel()
    if len(corners) < 3:
        return points
    hull: Array = points[np.roll(corners, -np.lexsort(grid[corners].T)[0])]
    return hull
