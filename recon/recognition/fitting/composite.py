"""Whole objects: parts of revolution stacked on one vertical axis, fitted together.

Each point belongs to the part whose outline is nearest in the (rho, y) profile, so no correct
segmentation is needed before the fit.
"""

from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.algebra import column_quantiles, quantiles
from recon.recognition.fitting.least_squares import Estimate, minimise
from recon.recognition.fitting.profiles import NUM_RADII, OUTLINES, to_parts
from recon.records import Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

Array = NDArray[np.float64]

SPLITS = (0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Initial heights of the boundary of two parts, as shares of the total height."""
WHOLE_CONE, ITS_RIM = np.array([1.3, 0.5]), np.array([1.1, 0.15])
"""Radii of a cone at first, over the distance of its points from the axis: if its whole side is
seen, and if little more than its rim is."""
SAME_CELLS = 0.5
"""Largest difference of a number of two fits, in cells, up to which they are the same."""
BELOW_CELLS = 0.3
"""Average height of the mean of a part's lowest cell above its rim; at the narrow end, seen from
below, it is nearly 0."""
NOISE_FLOOR = 0.05
"""Minimum noise assumed for a cell's mean, in cells."""
BULK = np.array([0.1, 0.9])
"""Quantiles that bound the bulk of the points, in whose middle the axis starts."""
INLIER_SIGMAS = 3.0
"""Points within this number of scales are on the fit."""
ENDS = np.array([0.005, 0.99])
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
        return _layout(self.shapes)

    def nearest(self, points: Array) -> tuple[Array, NDArray[np.intp]]:
        """Signed distances (N,) of points (N, 3) to the nearest part, and its number (N,)."""
        outlines, counts = self.layout
        signed, _, nearest = to_parts(
            points, self.axis, self.heights, outlines, np.concatenate(self.radii), counts
        )
        return signed, nearest


def _layout(shapes: tuple[str, ...]) -> NDArray[np.int64]:
    return np.array([[table[shape] for shape in shapes] for table in (OUTLINES, NUM_RADII)])


@dataclass(frozen=True, slots=True, eq=False)
class CompositeModel:
    """Points on the parts of a composite."""

    points: Array
    shapes: tuple[str, ...]
    surface = descent.COMPOSITE

    def packed(self, state: Composite) -> Array:
        """The numbers of a composite: axis, heights, radii."""
        return np.concatenate([state.axis, state.heights, *state.radii])

    def unpacked(self, numbers: Array) -> Composite:
        """The composite of its numbers."""
        ends = 3 + len(self.shapes)
        borders = ends + np.cumsum([NUM_RADII[shape] for shape in self.shapes])
        return Composite(
            shapes=self.shapes,
            axis=numbers[:2],
            heights=numbers[2:ends],
            radii=tuple(np.split(numbers[ends:], borders[:-1] - ends)),
        )


def fit_composites(
    shapes: tuple[str, ...], points: Array, ground: float, cell_size: float, weights: Array
) -> list[Estimate[Composite]]:
    """The most likely composites of `shapes` on the ground: all optima found, best first.

    Of a wall of many cells and a roof of few, the best one may be a tapered wall.

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
    model, floor = CompositeModel(points, shapes), NOISE_FLOOR * cell_size
    fits = [
        minimise(model, start, floor=floor, weights=weights, layout=_layout(shapes))
        for start in _starts(shapes, points, ground)
    ]
    optima: list[Estimate[Composite]] = []
    for fit in sorted(fits, key=lambda estimate: estimate.deviance):
        numbers, least = model.packed(fit.state), SAME_CELLS * cell_size
        if all(np.abs(model.packed(one.state) - numbers).max() > least for one in optima):
            optima.append(fit)
    return [replace(one, state=_trimmed(one, points, cell_size)) for one in optima]


def _trimmed(fit: Estimate[Composite], points: Array, cell_size: float) -> Composite:
    """Cut the last part where its points end: excess length costs a fit nothing."""
    composite = fit.state
    if composite.shapes[-1] in ("sphere", "ellipsoid"):
        return composite
    _, nearest = composite.nearest(points)
    own = (nearest == len(composite.shapes) - 1) & (
        np.abs(fit.residuals) < INLIER_SIGMAS * fit.sigma
    )
    if not own.any():
        return composite
    ends = quantiles(points[own, 1], ENDS) - [BELOW_CELLS * cell_size, 0.0]
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


def _starts(shapes: tuple[str, ...], points: Array, ground: float) -> list[Composite]:
    """Composites round the middle of the bulk, their boundaries at several heights."""
    low, high = column_quantiles(points, BULK)
    axis = (low + high)[::2] / 2.0
    rho, y = np.hypot(*(points[:, ::2] - axis).T), points[:, 1].copy()
    top = float(y.max())
    found = []
    for splits in _splits(len(shapes)):
        heights = ground + (top - ground) * np.array([0.0, *splits, 1.0])
        ends = pairwise(heights)
        middles = [_middle(rho, y, low, high) for low, high in ends]
        of_parts = zip(shapes, middles, strict=True)
        ways = [_first_radii(NUM_RADII[shape], middle, max(middles)) for shape, middle in of_parts]
        found += [
            Composite(shapes=shapes, axis=axis, heights=heights, radii=radii)
            for radii in product(*ways)
        ]
    return found


def _first_radii(number: int, middle: float, widest: float) -> list[Array]:
    """Ways to begin with a number of radii of a part, by the median distance of its points.

    A roof of which few points are seen is as wide as the widest part.
    """
    if number < len(WHOLE_CONE):
        return [np.full(number, middle)]
    return [middle * WHOLE_CONE, middle * ITS_RIM, widest * ITS_RIM]


@njit(cache=True)
def _middle(rho: Array, y: Array, low: float, high: float) -> float:
    """Median distance from the axis of the points between two heights, else of all."""
    inside = rho[(y >= low) & (y <= high)]
    median: float = np.median(inside if len(inside) else rho)
    return median


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
