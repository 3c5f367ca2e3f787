"""Whole objects: parts of revolution stacked on one vertical axis, fitted together.

Each point belongs to the part whose outline is nearest in the (rho, y) profile, so no correct
segmentation is needed before the fit.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.least_squares import Estimate, minimise
from recon.recognition.fitting.profiles import NUM_RADII, OUTLINES, to_parts
from recon.records import Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

Array = NDArray[np.float64]

SPLITS = (0.2, 0.4, 0.6, 0.8)
"""Initial heights of the boundary of two parts, as shares of the total height."""
ROUGH_POINTS, ROUGH_STEPS = 150, 6
"""Points and steps used to choose the most promising start."""
BELOW_CELLS = 0.3
"""Average height of the mean of a part's lowest cell above its rim; at the narrow end, seen from
below, it is nearly 0."""
NOISE_FLOOR = 0.05
"""Minimum noise assumed for a cell's mean, in cells."""
BULK = (0.1, 0.9)
"""Quantiles that bound the bulk of the points, in whose middle the axis starts."""
INLIER_SIGMAS = 3.0
"""Points within this number of scales are on the fit."""
ENDS = (0.005, 0.99)
"""Quantiles of a part's points at which it ends; its narrow end has few points."""
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
        """Height over radius (parts,); for a cone, over the decrease of its radius."""
        spans = np.diff(self.heights)
        narrowing = [abs(float(r[0] - r[1])) if len(r) > 1 else np.inf for r in self.radii]
        ratios: Array = spans / np.maximum(np.minimum(self.widest, narrowing), 1e-9)
        return ratios

    @property
    def areas(self) -> Array:
        """Approximate area (parts,) of each part: that of the cylinder or cone with its radii."""
        pairs = zip(self.shapes, self.radii, np.diff(self.heights), strict=True)
        rims = [(r[0], r[-1]) if len(r) else (span / 2.0, span / 2.0) for _, r, span in pairs]
        slants = np.hypot(np.diff(self.heights), [a - b for a, b in rims])
        areas: Array = np.pi * slants * np.array([a + b for a, b in rims])
        return areas


@dataclass(frozen=True, slots=True, eq=False)
class CompositeModel:
    """Distances of points to the nearest part of a composite."""

    points: Array

    def residuals(self, composite: Composite) -> tuple[Array, Array]:
        """Signed distances and their derivatives with respect to axis, heights and radii."""
        distances, gradient, _ = self.nearest(composite)
        return distances, gradient

    def nearest(self, composite: Composite) -> tuple[Array, Array, NDArray[np.intp]]:
        """Signed distances (N,), derivatives (N, P), and the nearest part (N,)."""
        radii = np.zeros((len(composite.shapes), 2))
        for row, own in zip(radii, composite.radii, strict=True):
            row[: len(own)] = own
        signed, gradient, nearest = to_parts(
            self.points,
            composite.axis,
            composite.heights,
            np.array([OUTLINES[shape] for shape in composite.shapes]),
            radii,
            np.array([len(own) for own in composite.radii]),
        )
        return signed, gradient, nearest

    def transformed(self, composite: Composite, step: Array) -> Composite:
        """The composite after a step; sizes stay positive and ends in order."""
        num_parts = len(composite.shapes)
        heights = composite.heights.copy()
        heights[1:] += step[2 : 2 + num_parts]
        heights = np.maximum.accumulate(heights)
        borders = np.cumsum([2 + num_parts, *map(len, composite.radii)])
        radii = tuple(
            np.abs(radii + step[low:high])
            for radii, low, high in zip(composite.radii, borders[:-1], borders[1:], strict=True)
        )
        return Composite(
            shapes=composite.shapes, axis=composite.axis + step[:2], heights=heights, radii=radii
        )


def fit_composite(
    shapes: tuple[str, ...], points: Array, ground: float, cell_size: float, weights: Array
) -> Estimate[Composite]:
    """The most likely composite of `shapes` on the ground.

    Parameters
    ----------
    points : (N, 3) float64
        World, y up.
    ground : float
        Height of the ground.
    cell_size : float
        Side of the cells whose means the points are, world units.
    weights : (N,) float64
        Weight of each point.
    """
    model, floor = CompositeModel(points), NOISE_FLOOR * cell_size
    starts = [_start(shapes, points, ground, splits) for splits in _splits(len(shapes))]
    some = slice(None, None, -(-len(points) // ROUGH_POINTS))
    few = CompositeModel(points[some])
    rough = [
        minimise(few, start, floor=floor, weights=weights[some], max_steps=ROUGH_STEPS)
        for start in starts
    ]
    best = min(rough, key=lambda estimate: estimate.deviance)
    fit = minimise(model, best.state, floor=floor, weights=weights)
    return replace(fit, state=_trimmed(fit, model, cell_size))


def _trimmed(fit: Estimate[Composite], model: CompositeModel, cell_size: float) -> Composite:
    """Cut the last part where its points end: excess length costs a fit nothing."""
    composite = fit.state
    if composite.shapes[-1] in ("sphere", "ellipsoid"):
        return composite
    _, _, nearest = model.nearest(composite)
    own = (nearest == len(composite.shapes) - 1) & (
        np.abs(fit.residuals) < INLIER_SIGMAS * fit.sigma
    )
    if not own.any():
        return composite
    ends = np.quantile(model.points[own, 1], ENDS) - [BELOW_CELLS * cell_size, 0.0]
    ends = np.clip(ends, *composite.heights[-2:])
    if len(composite.shapes) == 1:
        ends[0] = composite.heights[0]
    slope = float(composite.radii[-1][-1] - composite.radii[-1][0]) / max(
        np.diff(composite.heights)[-1], 1e-9
    )
    rim = composite.radii[-1][0] + slope * (ends - composite.heights[-2])
    if slope < 0:
        # Cameras below hardly see the tip. The end lies between the last cell and the tip, so the
        # midpoint is off by at most half of that distance.
        rise = 0.5 * min(rim[1] / -slope, ends[1] - ends[0])
        ends[1], rim[1] = ends[1] + rise, rim[1] + slope * rise
    radii = rim[-len(composite.radii[-1]) :]
    return replace(
        composite,
        heights=np.append(composite.heights[:-2], ends),
        radii=(*composite.radii[:-1], radii),
    )


def _splits(num_parts: int) -> list[tuple[float, ...]]:
    if num_parts == 1:
        return [()]
    if num_parts == 2:
        return [(share,) for share in SPLITS]
    return [tuple(np.linspace(0.0, 1.0, num_parts + 1)[1:-1])]


def _start(
    shapes: tuple[str, ...], points: Array, ground: float, splits: tuple[float, ...]
) -> Composite:
    low, high = np.quantile(points, BULK, axis=0)
    axis = (low + high)[::2] / 2.0
    top = float(points[:, 1].max())
    heights = ground + (top - ground) * np.array([0.0, *splits, 1.0])
    rho = np.hypot(*(points[:, ::2] - axis).T)
    radii = []
    for shape, low, high in zip(shapes, heights[:-1], heights[1:], strict=True):
        inside = rho[(points[:, 1] >= low) & (points[:, 1] <= high)]
        middle = float(np.median(inside)) if len(inside) else float(np.median(rho))
        radii.append(
            middle
            * np.array([1.3, 0.5] if shape == "truncated cone" else [1.0])[: NUM_RADII[shape]]
        )
    return Composite(shapes=shapes, axis=axis, heights=heights, radii=tuple(radii))


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
