"""Fitted solids as closed meshes, to be drawn over their cells."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.partition import RGB, PartCells
from recon.geometry import pose
from recon.libraries import load_pyvista
from recon.records import (
    Box,
    Cone,
    Cylinder,
    Ellipsoid,
    FoundObject,
    Plane,
    Sphere,
    TruncatedCone,
    Voxels,
)
from recon.records.extents import AROUND, rims

Array = NDArray[np.float64]

Bounded = Sphere | Ellipsoid | Cylinder | Cone | TruncatedCone | Box


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnSolid:
    """A part of an object as it is drawn."""

    solid: Bounded
    colour: RGB


def drawn_solids(voxels: Voxels, found: FoundObject) -> Iterator[DrawnSolid]:
    """The parts of an object in the colours of their cells, a plane as far as cells are on it.

    Solids that extend far beyond their object are left out: they fit only what was seen.
    """
    parts = PartCells.of(voxels, found)
    for number, part in enumerate(found.parts):
        solid = part.solid
        if isinstance(solid, Plane):
            own = parts.own(number)
            if len(own):
                yield DrawnSolid(solid=_flat_box(solid, own), colour=parts.colour(number))
        elif found.holds(solid):
            yield DrawnSolid(solid=solid, colour=parts.colour(number))


def _flat_box(plane: Plane, cells: Voxels) -> Box:
    """The piece of a plane on which cells lie, as a box without height."""
    # Late: they load SciPy and numba, which few figures need.
    from recon.recognition.fitting.axes import across_axis
    from recon.recognition.segments.boxes import upright_box

    first, second = across_axis(plane.normal)
    rotation = np.array([second, plane.normal, first])
    box = upright_box((cells.means - plane.point) @ rotation.T)
    return Box(
        centre=(box.centre * (1.0, 0.0, 1.0)) @ rotation + plane.point,
        axes=box.axes @ rotation,
        sizes=(box.sizes + cells.cell_size) * (1.0, 0.0, 1.0),
    )


def mesh(solid: Bounded) -> Any:
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
            return _frustum(solid.point, solid.axis, solid.height, (solid.radius, solid.radius))
        case Cone():
            end = solid.height * np.tan(solid.half_angle_rad)
            return _frustum(solid.apex, solid.axis, solid.height, (0.0, float(end)))
        case TruncatedCone():
            radii = solid.radius_bottom, solid.radius_top
            return _frustum(solid.point, solid.axis, solid.height, radii)
        case Box():
            cube = pyvista.Cube(
                x_length=solid.sizes[0], y_length=solid.sizes[1], z_length=solid.sizes[2]
            )
            return cube.transform(pose(solid.axes.T, solid.centre), inplace=False)


def triangles_of(solid: Bounded) -> tuple[Array, NDArray[np.int32]]:
    """Vertices (V, 3) and triangles (T, 3) of a solid's closed surface."""
    surface = mesh(solid).triangulate()
    return np.asarray(surface.points, np.float64), surface.regular_faces.astype(np.int32)


def _frustum(point: Array, axis: Array, height: float, radii: tuple[float, float]) -> Any:
    """The lateral surface between two circles, and the circles."""
    corners = rims(point, axis, height, radii)
    here = np.arange(AROUND)
    then = (here + 1) % AROUND
    sides = np.column_stack([np.full(AROUND, 4), here, then, then + AROUND, here + AROUND])
    ends = [[AROUND, *here], [AROUND, *(here + AROUND)]]
    return load_pyvista().PolyData(corners, faces=np.concatenate([sides.ravel(), *ends]))
