"""Footprints of solids and objects: outlines in x and z, counter-clockwise in (x, -z)."""

import numpy as np
from numpy.typing import NDArray

from recon.figures.partition import cells_of
from recon.records import Box, FoundObject, Solid, Voxels
from recon.records.extents import corners

Array = NDArray[np.float64]

GRID, TINY = 1 << 20, 1e-12
"""Steps of the grid on which hulls are found, along an outline; least size of an outline."""


def of_object(found: FoundObject, voxels: Voxels) -> Array:
    """Outline (N, 2) in x, z: of the solids, else of the box, else of the cells."""
    outlines = [of_solid(part.solid) for part in found.parts if found.holds(part.solid)]
    shown = [outline for outline in outlines if len(outline)]
    if shown:
        return _hull(np.vstack(shown))
    if found.box is not None:
        box = found.box
        return of_solid(Box(centre=box.centre, axes=box.axes, sizes=box.sizes))
    cells = cells_of(voxels, found)
    if len(cells) < 3:
        return rectangle(found.centre[[0, 2]], np.eye(2), found.size[[0, 2]])
    return least_rectangle(cells.means[:, [0, 2]])


def of_solid(solid: Solid) -> Array:
    """Outline (N, 2) in x, z of a solid seen from above; (0, 2) for a plane, which has none."""
    return _hull(corners(solid)[:, [0, 2]])


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
    rows = convexHull(grid, clockwise=True, returnPoints=False).ravel()
    if len(rows) < 3:
        return points
    hull: Array = points[np.roll(rows, -np.lexsort(grid[rows].T)[0])]
    return hull
