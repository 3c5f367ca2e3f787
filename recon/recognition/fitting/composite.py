"""Whole objects: parts of revolution stacked on one vertical axis, fitted together.

Each point belongs to the part whose outline is nearest in the (rho, y) profile, so no correct
segmentation is needed before the fit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.profiles import NUM_RADII, OUTLINES, to_parts
from recon.records import Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

Array = NDArray[np.float64]

NOISE_FLOOR = 0.05
"""Minimum noise assumed for a cell's mean, in cells."""
POINTED = 0.05
"""A truncated cone whose top is narrower than this share of its bottom is a cone."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Composite:
    """Upright parts on one axis; part i extends from `heights[i]` to `heights[i + 1]`."""

    shapes: tuple[str, ...]
    """From the ground up."""
    axis: Array
    """(2,) x and z of the vertical axis."""
    heights: Array
    """(parts + 1,) y of the ends; the first is the ground."""
    radii: tuple[Array, ...]
    """The radii of each part, `NUM_RADII` per shape."""

    @property
    def widest(self) -> Array:
        """Largest radius (parts,) of each part."""
        pairs = zip(self.shapes, self.radii, np.diff(self.heights), strict=True)
        return np.array([r.max() if len(r) else span / 2.0 for _, r, span in pairs])

    @property
    def slenderness(self) -> Array:
        """Height over radius (parts,); for a cone, over the decrease of its radius.

        Negative for a cone that widens upwards.
        """
        falls = np.array([float(r[0] - r[1]) if len(r) > 1 else np.inf for r in self.radii])
        breadths = np.maximum(np.minimum(self.widest, np.abs(falls)), 1e-9)
        ratios: Array = np.copysign(np.diff(self.heights) / breadths, falls)
        return ratios

    @property
    def overall_slenderness(self) -> float:
        """Height over largest radius."""
        return float(np.ptp(self.heights) / max(self.widest.max(), 1e-9))

    @property
    def areas(self) -> Array:
        """Approximate area (parts,) of each part: that of the cylinder or cone with its radii."""
        pairs = zip(self.shapes, self.radii, np.diff(self.heights), strict=True)
        rims = [(r[0], r[-1]) if len(r) else (span / 2.0, span / 2.0) for _, r, span in pairs]
        slants = np.hypot(np.diff(self.heights), [a - b for a, b in rims])
        areas: Array = np.pi * slants * np.array([a + b for a, b in rims])
        return areas

    @property
    def layout(self) -> NDArray[np.int64]:
        """(2, parts) outlines, and counts of radii."""
        return layout_of(self.shapes)

    def nearest(self, points: Array) -> tuple[Array, NDArray[np.intp]]:
        """Signed distances (N,) of points (N, 3) to the nearest part, and its number (N,)."""
        outlines, counts = self.layout
        signed, _, nearest = to_parts(
            points, self.axis, self.heights, outlines, np.concatenate(self.radii), counts
        )
        return signed, nearest


def layout_of(shapes: tuple[str, ...]) -> NDArray[np.int64]:
    """(2, parts) outlines, and counts of radii, of parts."""
    return np.array([[table[shape] for shape in shapes] for table in (OUTLINES, NUM_RADII)])


def unpacked(shapes: tuple[str, ...], numbers: Array) -> Composite:
    """The composite of its numbers: axis, heights, radii."""
    first, radii = 3 + len(shapes), []
    for shape in shapes:
        radii.append(numbers[first : first + NUM_RADII[shape]])
        first += NUM_RADII[shape]
    return Composite(
        shapes=shapes, axis=numbers[:2], heights=numbers[2 : 3 + len(shapes)], radii=tuple(radii)
    )


def solids(composite: Composite) -> list[Solid]:
    """The parts of a composite as solids in the world frame, from the ground up."""
    ends = zip(composite.heights[:-1], composite.heights[1:], strict=True)
    return [
        _solid(shape, composite.axis, float(low), float(high), radii)
        for shape, (low, high), radii in zip(composite.shapes, ends, composite.radii, strict=True)
    ]


def _solid(shape: str, axis: Array, low: float, high: float, radii: Array) -> Solid:
    x, z = axis
    up, bottom = np.array([0.0, 1.0, 0.0]), np.array([x, low, z])
    middle, height = np.array([x, (low + high) / 2.0, z]), high - low
    if shape == "sphere":
        return Sphere(centre=middle, radius=height / 2.0)
    if shape == "ellipsoid":
        halves = np.array([radii[0], height / 2.0, radii[0]])
        order = np.argsort(-halves, kind="stable")
        return Ellipsoid(centre=middle, radii=halves[order], axes=np.eye(3)[order])
    if shape == "cylinder":
        return Cylinder(point=bottom, axis=up, radius=float(radii[0]), height=height)
    if radii[1] < POINTED * radii[0]:
        angle = float(np.arctan2(radii[0] - radii[1], height))
        tip = high + float(radii[1] / np.tan(angle))
        apex = np.array([x, tip, z])
        return Cone(apex=apex, axis=-up, half_angle_rad=angle, height=tip - low)
    return TruncatedCone(
        point=bottom,
        axis=up,
        radius_bottom=float(radii[0]),
        radius_top=float(radii[1]),
        height=height,
    )
