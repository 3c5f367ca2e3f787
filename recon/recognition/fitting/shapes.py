"""The solid that a set of points lies on: robust geometric fits, compared by BIC."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, as_numbers, check_shape
from recon.recognition.fitting.axial_shapes import AxialModel
from recon.recognition.fitting.flat_shapes import BoxModel, PlaneModel
from recon.recognition.fitting.least_squares import minimise
from recon.recognition.fitting.normals import estimate_normals
from recon.recognition.fitting.round_shapes import EllipsoidModel, SphereModel
from recon.records import FitFailure, Solid

Array = NDArray[np.float64]

SAMPLE = 800
"""Points a choice of shape is made on: more do not change it."""
LARGE_SAMPLE = 10_000
"""Points the chosen solid is refined on."""
RELATIVE_FLOOR = 1e-4
"""No cloud is truer than this share of its size: facets, rounding."""
AS_GOOD = 0.1
"""Fits are equally good that differ by less in BIC a point (5 percent of noise), or by one
parameter, however many points say so: cells and facets err together, which no criterion over single
points knows."""
ROUGH_STEPS = 4
"""Steps that show which of several starts is promising."""
SMALLEST, LARGEST = 1e-60, 1e60
"""Extent and reach whose fourth powers are still numbers."""
INLIER_SIGMAS = 4.0
"""Points nearer than so many scales lie on a fit, and set its ends."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate:
    """One solid fitted to points."""

    solid: Solid
    rms: float
    """Root mean square of the geometric distances of all points, in their unit."""
    bic: float
    """The smallest is best; comparable within one set of points only."""
    sigma: float
    """Scale of the noise, outliers aside."""
    covariance: Array
    """(P, P) of the surface's parameters, in the order of its model's steps."""


def fit(points: ArrayLike, weights: ArrayLike | None = None) -> Solid | FitFailure:
    """The solid that points lie on.

    Parameters
    ----------
    points : (N, 3) array_like
        In any frame and unit; neither changes the shape found.
    weights : (N,) array_like, optional
        How much each point counts, such as the number of points a cell's mean is made of.

    Returns
    -------
    Solid or FitFailure
        The candidate of smallest BIC; a falsy reason where the points show no solid.
    """
    found = candidates(points, weights)
    return found if isinstance(found, FitFailure) else found[0].solid


def candidates(
    points: ArrayLike, weights: ArrayLike | None = None
) -> tuple[Candidate, ...] | FitFailure:
    """Every solid that could be fitted to points (N, 3), the best first."""
    sample = _sample(points, weights, SAMPLE)
    if isinstance(sample, FitFailure):
        return sample
    fits = [_fitted(make, sample) for make in MODELS.values()]
    found = [one for one in fits if isinstance(one, Candidate)]
    if not found:
        return FitFailure("no solid fits the points")
    ranked = sorted(found, key=lambda one: one.bic)
    count = len(sample.points)
    limit = ranked[0].bic + AS_GOOD * count + np.log(count)
    chosen = next(one for one in found if one.bic <= limit)
    return (chosen, *(one for one in ranked if one is not chosen))


def from_points(
    shape: str, points: ArrayLike, weights: ArrayLike | None = None
) -> Candidate | FitFailure:
    """Fit one shape, a key of `MODELS`, to points (N, 3); a cone may come out truncated."""
    if shape not in MODELS:
        raise InputError(f"shape is {shape!r}, but one of {', '.join(MODELS)} is needed")
    sample = _sample(points, weights, LARGE_SAMPLE)
    return sample if isinstance(sample, FitFailure) else _fitted(MODELS[shape], sample)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Sample:
    """Data of a fit."""

    points: Array
    normals: Array
    weights: Array


def _sample(points: ArrayLike, weights: ArrayLike | None, most: int) -> _Sample | FitFailure:
    cloud = as_numbers("points", points)
    check_shape("points", cloud, (None, 3))
    share = np.ones(len(cloud)) if weights is None else np.asarray(weights, dtype=np.float64)
    check_shape("weights", share, (len(cloud),))
    fault = _fault(cloud)
    if fault:
        return FitFailure(fault)
    if len(cloud) > most:
        rows = np.random.default_rng(0).choice(len(cloud), most, replace=False)
        cloud, share = cloud[rows], share[rows]
    return _Sample(points=cloud, normals=estimate_normals(cloud), weights=share)


def _fault(points: Array) -> str:
    """Why no solid can lie on the points; empty where one can."""
    num_bad = int((~np.isfinite(points).all(axis=1)).sum())
    if num_bad:
        return f"{num_bad} of {len(points)} points are not finite"
    distinct = np.unique(points, axis=0)
    if len(distinct) < 4:
        return f"{len(distinct)} distinct points are too few; 4 are needed"
    extent = float(np.ptp(distinct, axis=0).max())
    if not (extent > SMALLEST and np.abs(distinct).max() < LARGEST):
        return f"the points reach over {extent:g}, beyond what can be computed with"
    spread = np.linalg.svd(distinct - distinct.mean(axis=0), compute_uv=False)
    if spread[1] < 1e-6 * spread[0]:
        return "the points lie on one line"
    return ""


def _fitted(make: Callable[[Array, Array], Any], sample: _Sample) -> Candidate | FitFailure:
    points, weights = sample.points, sample.weights
    model = make(points, sample.normals)
    spare = len(points) - model.num_parameters - 1
    if spare < 1:
        return FitFailure("too few points for the shape")
    floor = RELATIVE_FLOOR * float(np.sqrt(points.var(axis=0).sum()))
    search = partial(minimise, model, floor=floor, weights=weights)
    starts = model.starts()
    if len(starts) > 1:
        rough = [search(start, max_steps=ROUGH_STEPS) for start in starts]
        starts = [min(rough, key=lambda one: one.deviance).state]
    estimate = search(starts[0])
    inliers = points[np.abs(estimate.residuals) <= INLIER_SIGMAS * estimate.sigma]
    solid = model.solid(estimate.state, inliers, estimate.sigma)
    if isinstance(solid, FitFailure):
        return solid
    # The correction for few points is that of AICc.
    penalty = model.num_parameters * np.log(len(points)) * len(points) / spare
    return Candidate(
        solid=solid,
        rms=float(np.sqrt(np.mean(solid.distances(points) ** 2))),
        bic=estimate.deviance + float(penalty),
        sigma=estimate.sigma,
        covariance=estimate.covariance,
    )


# Of fits that are equally good the first is taken.
MODELS: dict[str, Callable[[Array, Array], Any]] = {
    "plane": PlaneModel,
    "cylinder": partial(AxialModel, is_cone=False),
    "sphere": SphereModel,
    "cone": partial(AxialModel, is_cone=True),
    "ellipsoid": EllipsoidModel,
    "box": BoxModel,
}
