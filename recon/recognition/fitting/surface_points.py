"""Points spread evenly over the surfaces of solids."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import WORLD_UP
from recon.recognition.fitting.axes import across_axis
from recon.records import Box, Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface:
    """Points on an object with outward normals, their parts, and the total area."""

    points: Array
    normals: Array
    part: NDArray[np.intp]
    area: float


def area(solid: Solid) -> float:
    """Area of a bounded solid's surface."""
    return float(_patches(solid).areas.sum())


def surface(parts: Sequence[Solid], num_points: int, rng: np.random.Generator) -> Surface:
    """Points spread evenly over solids."""
    patches = [_patches(solid) for solid in parts]
    areas = np.array([own.areas.sum() for own in patches])
    pieces = [
        own.draw(rng.multinomial(int(num_points * share), own.areas / own.areas.sum()), rng)
        for own, share in zip(patches, areas / areas.sum(), strict=True)
    ]
    return Surface(
        points=np.concatenate([points for points, _ in pieces]),
        normals=np.concatenate([normals for _, normals in pieces]),
        part=np.repeat(np.arange(len(pieces)), [len(points) for points, _ in pieces]),
        area=float(areas.sum()),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Bands:
    """Strips of a surface of revolution, each between two circles."""

    origin: Array
    axis: Array
    outline: Array
    """(B + 1, 2) place along the axis and radius of the circles."""

    @property
    def areas(self) -> Array:
        """(B,)"""
        slants = np.hypot(*np.diff(self.outline, axis=0).T)
        radii = self.outline[:, 1]
        areas: Array = np.pi * slants * (radii[:-1] + radii[1:])
        return areas

    def draw(self, counts: NDArray[np.integer], rng: np.random.Generator) -> tuple[Array, Array]:
        """So many points on each band, and their normals."""
        band = np.repeat(np.arange(len(counts)), counts)
        start, run = self.outline[band], np.diff(self.outline, axis=0)[band]
        # Area grows with the radius: the position along a band is drawn by the inverse of its
        # cumulative area.
        low, high = start[:, 1], self.outline[band + 1, 1]
        share = rng.uniform(size=len(band))
        slope = np.where(np.abs(high - low) > 1e-9 * (high + low), high - low, np.inf)
        inverse = (np.sqrt(low**2 + share * (high**2 - low**2)) - low) / slope
        share = np.where(np.isfinite(slope), inverse, share)
        t, rho = (start + share[:, None] * run).T
        turn = rng.uniform(0.0, 2.0 * np.pi, len(band))
        radial = np.column_stack([np.cos(turn), np.sin(turn)]) @ across_axis(self.axis)
        along, out = (run / np.hypot(*run.T)[:, None]).T
        points = self.origin + t[:, None] * self.axis + rho[:, None] * radial
        return points, along[:, None] * radial - out[:, None] * self.axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Faces:
    """The six faces of a box."""

    box: Box

    @property
    def areas(self) -> Array:
        """(6,) two for each axis."""
        x, y, z = self.box.sizes
        return np.repeat([y * z, z * x, x * y], 2)

    def draw(self, counts: NDArray[np.integer], rng: np.random.Generator) -> tuple[Array, Array]:
        """So many points on each face, and their normals."""
        face = np.repeat(np.arange(6), counts)
        local = rng.uniform(-0.5, 0.5, (len(face), 3))
        side = np.where(face % 2, -1.0, 1.0)
        local[np.arange(len(face)), face // 2] = side / 2.0
        points = self.box.centre + local * self.box.sizes @ self.box.axes
        return points, side[:, None] * self.box.axes[face // 2]


def _patches(solid: Solid) -> _Bands | _Faces:
    """The pieces of a surface to draw points on; an ellipsoid must be one of revolution."""
    if isinstance(solid, Box):
        return _Faces(box=solid)
    origin, axis, circles = outline(solid)
    return _Bands(origin=origin, axis=axis, outline=circles)


def outline(solid: Solid) -> tuple[Array, Array, Array]:
    """Origin and axis of a solid of revolution, and corners (t, radius) of its outline."""
    arc = np.linspace(-np.pi / 2.0, np.pi / 2.0, 65)
    arc = np.column_stack([np.sin(arc), np.cos(arc)])
    if isinstance(solid, Sphere):
        return solid.centre, np.array(WORLD_UP), solid.radius * arc
    if isinstance(solid, Ellipsoid):
        # The half axis that differs is the axis; the other two are equal.
        lone = 0 if np.ptp(solid.radii[1:]) < np.ptp(solid.radii[:2]) else 2
        return solid.centre, solid.axes[lone], arc * [solid.radii[lone], solid.radii[1]]
    if isinstance(solid, Cone):
        rim = solid.height * float(np.tan(solid.half_angle_rad))
        return solid.apex, -solid.axis, np.array([[-solid.height, rim], [0.0, 0.0]])
    if isinstance(solid, Cylinder | TruncatedCone):
        radii = (
            [solid.radius] * 2
            if isinstance(solid, Cylinder)
            else [solid.radius_bottom, solid.radius_top]
        )
        return solid.point, solid.axis, np.column_stack([[0.0, solid.height], radii])
    raise InputError(f"a {solid.kind} is unbounded, but a bounded solid is needed")
