"""Fits of composites: the most promising one, or all optima."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.fitting.algebra import column_quantiles, quantiles
from recon.recognition.fitting.composite import NOISE_FLOOR, Composite, layout_of, unpacked
from recon.recognition.fitting.descent import COMPOSITE, descents
from recon.recognition.fitting.least_squares import (
    MOST_STEPS,
    Estimate,
    minimise,
    most_promising,
)
from recon.recognition.fitting.profiles import NUM_RADII

Array = NDArray[np.float64]

SPLITS, CLOSE_SPLITS = (0.2, 0.4, 0.6, 0.8), (0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Initial heights of the boundary of two parts, as shares of the total height: those of one fit,
and those of all fits."""
ROUGH_POINTS, ROUGH_STEPS = 150, 6
"""Points and steps used to choose the most promising start of one fit."""
WHOLE_CONE, ITS_RIM = np.array([1.3, 0.5]), np.array([1.1, 0.15])
"""Radii of a cone at first, over the distance of its points from the axis: if its whole side is
seen, and if little more than its rim is."""
SAME_CELLS = 0.5
"""Largest difference of a number of two fits, in cells, up to which they are the same."""
BELOW_CELLS = 0.3
"""Average height of the mean of a part's lowest cell above its rim; at the narrow end, seen from
below, it is nearly 0."""
BULK = np.array([0.1, 0.9])
"""Quantiles that bound the bulk of the points, in whose middle the axis starts."""
INLIER_SIGMAS = 3.0
"""Points within this number of scales are on the fit."""
ENDS = np.array([0.005, 0.99])
"""Quantiles of a part's points at which it ends; its narrow end has few points."""


def fit_composite(
    shapes: tuple[str, ...], points: Array, ground: float, cell_size: float, weights: Array
) -> Estimate[Composite]:
    """A likely composite of `shapes` on the ground: that of the most promising start.

    Its parameters are those of `fit_composites`, of which it takes a fifth of the time.
    """
    some, layout = slice(None, None, -(-len(points) // ROUGH_POINTS)), layout_of(shapes)
    starts = _starts(shapes, points, ground, SPLITS, num_ways=1)
    floor, few = NOISE_FLOOR * cell_size, weights[some]
    start = most_promising(
        COMPOSITE,
        np.ascontiguousarray(points[some]),
        starts,
        share=few / few.mean(),
        floor=floor,
        layout=layout,
        num_steps=ROUGH_STEPS,
    )
    share = weights / weights.mean()
    fit = minimise(COMPOSITE, points, start, share=share, floor=floor, layout=layout)
    return _trimmed(shapes, fit, points, cell_size)


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
    some, layout = slice(None, None, -(-len(points) // ROUGH_POINTS)), layout_of(shapes)
    starts = _starts(shapes, points, ground, CLOSE_SPLITS)
    floor, few, share = NOISE_FLOOR * cell_size, weights[some], weights / weights.mean()
    rough, lowest = descents(
        COMPOSITE,
        np.ascontiguousarray(points[some]),
        starts,
        layout,
        few / few.mean(),
        floor,
        MOST_STEPS,
    )
    fits = [
        minimise(COMPOSITE, points, rough[row], share=share, floor=floor, layout=layout)
        for row in _distinct(rough, lowest, cell_size)
    ]
    found = np.stack([one.state for one in fits]), np.array([one.deviance for one in fits])
    optima = [fits[row] for row in _distinct(*found, cell_size)]
    return [_trimmed(shapes, one, points, cell_size) for one in optima]


def _distinct(numbers: Array, deviances: Array, cell_size: float) -> list[int]:
    """Rows of the fits (M, S) that differ from every better one, best first."""
    distinct: list[int] = []
    for row in np.argsort(deviances, kind="stable").tolist():
        away = np.abs(numbers[distinct] - numbers[row]).max(axis=1)
        if (away > SAME_CELLS * cell_size).all():
            distinct.append(row)
    return distinct


def _trimmed(
    shapes: tuple[str, ...], fit: Estimate[Array], points: Array, cell_size: float
) -> Estimate[Composite]:
    """The fit as a composite, its last part cut where its points end: excess costs nothing."""
    composite = unpacked(shapes, fit.state)
    if shapes[-1] not in ("sphere", "ellipsoid"):
        _, nearest = composite.nearest(points)
        is_close = np.abs(fit.residuals) < INLIER_SIGMAS * fit.sigma
        own = (nearest == len(shapes) - 1) & is_close
        if own.any():
            composite = _cut(composite, points[own, 1], cell_size)
    return fit.as_of(composite)


def _cut(composite: Composite, heights: Array, cell_size: float) -> Composite:
    """A composite whose last part ends at some of its points' heights (N,)."""
    ends = quantiles(heights, ENDS) - [BELOW_CELLS * cell_size, 0.0]
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
    return replace(
        composite,
        heights=np.append(composite.heights[:-2], ends),
        radii=(*composite.radii[:-1], rim[-len(composite.radii[-1]) :]),
    )


def _splits(num_parts: int, of_two: tuple[float, ...]) -> list[tuple[float, ...]]:
    if num_parts == 1:
        return [()]
    if num_parts == 2:
        return [(share,) for share in of_two]
    return [tuple(np.linspace(0.0, 1.0, num_parts + 1)[1:-1])]


def _starts(
    shapes: tuple[str, ...],
    points: Array,
    ground: float,
    of_two: tuple[float, ...],
    num_ways: int | None = None,
) -> Array:
    """Numbers (M, S) of composites round the middle of the bulk, split at several heights.

    Parameters
    ----------
    of_two : tuple of float
        Heights of the boundary of two parts, as shares of the total height.
    num_ways : int, optional
        Most ways to begin with the radii of a part; by default all.
    """
    low, high = column_quantiles(points, BULK)
    axis = (low + high)[::2] / 2.0
    rho, y = np.hypot(*(points[:, ::2] - axis).T), points[:, 1].copy()
    top = float(y.max())
    found = []
    for splits in _splits(len(shapes), of_two):
        heights = ground + (top - ground) * np.array([0.0, *splits, 1.0])
        middles = [_middle(rho, y, low, high) for low, high in pairwise(heights)]
        ways = [
            _first_radii(NUM_RADII[shape], middle, max(middles))[:num_ways]
            for shape, middle in zip(shapes, middles, strict=True)
        ]
        found += [np.concatenate([axis, heights, *radii]) for radii in product(*ways)]
    return np.stack(found)


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
