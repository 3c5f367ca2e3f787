"""Points spread evenly over the surfaces of solids."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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
    return sum(patch.area for patch in _patches(solid))


def surface(parts: Sequence[Solid], num_points: int, rng: np.random.Generator) -> Surface:
    """Points spread evenly over solids."""
    patches = [_patches(solid) for solid in parts]
    areas = np.array([sum(patch.area for patch in own) for own in patches])
    pieces = [
        _spread(own, int(num_points * share), rng)
        for own, share in zip(patches, areas / areas.sum(), strict=True)
    ]
    return Surface(
        points=np.concatenate([points for points, _ in pieces]),
        normals=np.concatenate([normals for _, normals in pieces]),
        part=np.repeat(np.arange(len(pieces)), [len(points) for points, _ in pieces]),
        area=float(areas.sum()),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Band:
    """A strip of a surface of revolution, between two circles."""

    origin: Array
    axis: Array
    start: Array
    """(2,) position along the axis, radius."""
    end: Array

    @property
    def area(self) -> float:
        slant = float(np.hypot(*(self.end - self.start)))
        return float(np.pi * slant * (self.start[1] + self.end[1]))

    def draw(self, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
        # Area grows with the radius: the position along a band is drawn by the inverse of its
        # cumulative area.
        low, high = self.start[1], self.end[1]
        share = rng.uniform(size=count)
        if abs(high - low) > 1e-9 * (high + low):
            share = (np.sqrt(low**2 + share * (high**2 - low**2)) - low) / (high - low)
        t, rho = self.start[:, None] + (self.end - self.start)[:, None] * share
        turn = rng.uniform(0.0, 2.0 * np.pi, count)
        across = across_axis(self.axis)
        radial = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        points = self.origin + t[:, None] * self.axis + rho[:, None] * radial
        rise, run = (self.end - self.start) / np.hypot(*(self.end - self.start))
        return points, rise * radial - run * self.axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Face:
    """A parallelogram centred at `centre` with edges `first` and `second`."""

    centre: Array
    first: Array
    second: Array
    normal: Array

    @property
    def area(self) -> float:
        return float(np.linalg.norm(np.cross(self.first, self.second)))

    def draw(self, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
        share = rng.uniform(-0.5, 0.5, (count, 2))
        points = self.centre + share @ np.stack([self.first, self.second])
        return points, np.broadcast_to(self.normal, points.shape)


def _patches(solid: Solid) -> list[_Band | _Face]:
    """The pieces of a surface to draw points on; an ellipsoid must be one of revolution."""
    if isinstance(solid, Box):
        return _faces(solid)
    origin, axis, outline = _outline(solid)
    return [_Band(origin=origin, axis=axis, start=a, end=b) for a, b in pairwise(outline)]


def _faces(box: Box) -> list[_Band | _Face]:
    edges = box.axes * box.sizes[:, None]
    return [
        _Face(
            centre=box.centre + side * edges[k] / 2.0,
            first=edges[k - 2],
            second=edges[k - 1],
            normal=side * box.axes[k],
        )
        for k in range(3)
        for side in (1.0, -1.0)
    ]


def _outline(solid: Solid) -> tuple[Array, Array, Array]:
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


def _spread(
    patches: Sequence[_Band | _Face], count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    areas = np.array([patch.area for patch in patches])
    counts = rng.multinomial(count, areas / areas.sum())
    drawn = [patch.draw(int(own), rng) for patch, own in zip(patches, counts, strict=True)]
    return np.concatenate([p for p, _ in drawn]), np.concatenate([n for _, n in drawn])
