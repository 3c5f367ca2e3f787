"""Visuals as triangles with texture coordinates."""

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    PolygonVisual,
    SphereVisual,
    Vector,
    Visual,
)

# A file's Slices and Stacks set OpenGL's resolution; here every solid is round to less than a
# thousandth of its radius.
SLICES = 96
SPHERE_STACKS = 48
CONE_STACKS = 16

SLIVER = 1e-9
"""Minimum area of a triangle, relative to the sum of its squared edges."""

WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Triangles:
    """Triangles in the world; corners run counter-clockwise seen from the front."""

    corners: Array
    """(T, 3, 3) triangle, corner, xyz."""
    normals: Array
    """(T, 3, 3) unit normals of the surface at the corners."""
    uv: Array
    """(T, 3, 2) texture coordinates: 1 is one repeat; v grows downwards."""
    colours: Array
    """(T, 3, 3) red, green, blue from 0 to 1, multiplied with the texture."""

    def without_slivers(self) -> "Triangles":
        """The triangles that have an area."""
        edges = self.corners[:, 1:] - self.corners[:, :1]
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        keep = area > SLIVER * (edges**2).sum(axis=(1, 2))
        return Triangles(
            corners=self.corners[keep],
            normals=self.normals[keep],
            uv=self.uv[keep],
            colours=self.colours[keep],
        )


def sphere_triangles(visual: SphereVisual | EllipsoidVisual, tile: float) -> Triangles:
    """Triangles of a sphere or ellipsoid, its poles at the top and bottom.

    A texture covers `tile` world units before it repeats, so that it looks the same at any size.
    """
    radii = np.zeros(3) + (visual.radius if isinstance(visual, SphereVisual) else visual.radii)
    polar = np.linspace(0.0, np.pi, SPHERE_STACKS + 1)
    azimuth = np.linspace(0.0, 2.0 * np.pi, SLICES + 1)
    ring = np.sin(polar)[:, None]
    unit = np.stack(
        [
            ring * np.sin(azimuth),
            np.broadcast_to(np.cos(polar)[:, None], (len(polar), len(azimuth))),
            ring * np.cos(azimuth),
        ],
        axis=-1,
    )
    around, along = np.pi * (radii[0] + radii[2]), np.pi * np.cbrt(radii.prod())
    normals = unit / radii
    return _grid_triangles(
        unit * radii + np.array(visual.centre),
        normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        _grid_uv(unit.shape[:2], around, along, tile),
    )


def cylinder_triangles(visual: CylinderVisual, tile: float) -> Triangles:
    """Triangles of an open cylinder or truncated cone; a texture covers `tile` world units."""
    base, top, height = visual.radius_base, visual.radius_top, visual.height
    stacks = 1 if base == top else CONE_STACKS
    share = np.linspace(0.0, 1.0, stacks + 1)[:, None]
    # Counter-clockwise seen along -z, so that the grid's front is the outside.
    azimuth = -np.linspace(0.0, 2.0 * np.pi, SLICES + 1)[None, :]
    radius = base + share * (top - base)
    points = np.stack(
        np.broadcast_arrays(radius * np.cos(azimuth), radius * np.sin(azimuth), share * height),
        axis=-1,
    )
    slant = np.hypot(height, top - base)
    normals = np.stack(
        np.broadcast_arrays(
            np.cos(azimuth) * height / slant,
            np.sin(azimuth) * height / slant,
            np.full_like(share, (base - top) / slant),
        ),
        axis=-1,
    )
    R = quarter_turns(visual.rotation)
    return _grid_triangles(
        points @ R.T + np.array(visual.translation),
        normals @ R.T,
        _grid_uv(points.shape[:2], 2.0 * np.pi * max(base, top), slant, tile),
    )


def lid_triangles(visual: CylinderVisual) -> tuple[Triangles, Triangles]:
    """Cones inside an open cylinder that close its ends against rays along its axis."""
    bare = visual.height
    return (
        cylinder_triangles(dataclasses.replace(visual, radius_base=0.0), bare),
        cylinder_triangles(dataclasses.replace(visual, radius_top=0.0), bare),
    )


def polygon_triangles(visual: PolygonVisual) -> Triangles:
    """A polygon as a fan around its first corner, with its own colours and coordinates."""
    count = len(visual.vertices)
    fan = np.array([(0, n, n + 1) for n in range(1, count - 1)])
    corners = np.array([vertex.position for vertex in visual.vertices], np.float64)[fan]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    length = np.linalg.norm(normal)
    normal = normal / length if length > 0 else normal
    return Triangles(
        corners=corners,
        normals=np.broadcast_to(normal, corners.shape),
        uv=np.array([vertex.uv for vertex in visual.vertices])[fan],
        colours=np.array([vertex.colour[:3] for vertex in visual.vertices])[fan].clip(0.0, 1.0),
    )


def contains(visual: Visual, points: Array) -> NDArray[np.bool_]:
    """Mask of the points (N, 3) in a sphere, an ellipsoid, or a cylinder closed at its ends."""
    if isinstance(visual, SphereVisual | EllipsoidVisual):
        reach = visual.radius if isinstance(visual, SphereVisual) else np.array(visual.radii)
        inside: NDArray[np.bool_] = np.linalg.norm((points - visual.centre) / reach, axis=1) <= 1.0
        return inside
    if not isinstance(visual, CylinderVisual):
        return np.zeros(len(points), bool)
    own = (points - np.array(visual.translation)) @ quarter_turns(visual.rotation)
    share = own[:, 2] / visual.height
    radius = visual.radius_base + share * (visual.radius_top - visual.radius_base)
    within: NDArray[np.bool_] = (
        (share >= 0) & (share <= 1) & (np.hypot(own[:, 0], own[:, 1]) <= radius)
    )
    return within


def quarter_turns(rotation: Vector) -> Array:
    """(3, 3) rotation by quarter turns about x, then y, then z; exact for whole turns."""
    R = np.eye(3)
    for axis, turns in enumerate(rotation):
        angle = turns * np.pi / 2.0
        c, s = (np.round(w) if turns == round(turns) else w for w in (np.cos(angle), np.sin(angle)))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
        R = turn @ R
    return R


def _grid_uv(shape: tuple[int, int], around: float, along: float, tile: float) -> Array:
    """Coordinates of a grid that is `around` wide and `along` high, in whole repeats around."""
    repeats = max(1.0, np.round(around / tile))
    v, u = np.meshgrid(
        np.linspace(0.0, along / tile, shape[0]), np.linspace(0.0, repeats, shape[1]), indexing="ij"
    )
    return np.stack([u, v], axis=-1)


def _grid_triangles(points: Array, normals: Array, uv: Array) -> Triangles:
    """Two triangles per cell of grids (A, B, ...); the outside is left of a row's direction."""
    number = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    index: NDArray[np.int64] = np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])
    corners = points.reshape(-1, 3)[index]
    return Triangles(
        corners=corners,
        normals=normals.reshape(-1, 3)[index],
        uv=uv.reshape(-1, 2)[index],
        colours=np.broadcast_to(np.array(WHITE), corners.shape),
    )
