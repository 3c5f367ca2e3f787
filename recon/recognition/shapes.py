"""Which solid a set of points lies on: robust geometric fits, compared by BIC."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_shape
from recon.recognition.axial_shapes import AxialModel
from recon.recognition.flat_shapes import BoxModel, PlaneModel
from recon.recognition.least_squares import minimise
from recon.recognition.normals import estimate_normals
from recon.recognition.round_shapes import EllipsoidModel, SphereModel
from recon.records import FitFailure, Solid

Array = NDArray[np.float64]

SAMPLE = 800
"""Points a choice of shape is made on: more do not change it."""
LARGE_SAMPLE = 10_000
"""Points the chosen solid is refined on."""
RELATIVE_FLOOR = 1e-4
"""No cloud is truer than this share of its size: facets, rounding."""
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


def fit(points: ArrayLike) -> Solid | FitFailure:
    """The solid that points lie on.

    Parameters
    ----------
    points : (N, 3) array_like
        In any frame and unit; neither changes the shape found.

    Returns
    -------
    Solid or FitFailure
        The candidate of smallest BIC; a falsy reason where the points show no solid.
    """
    found = candidates(points)
    return found if isinstance(found, FitFailure) else found[0].solid


def candidates(points: ArrayLike) -> tuple[Candidate, ...] | FitFailure:
    """Every solid that could be fitted to points (N, 3), the best first."""
    cloud = _usable(np.asarray(points, dtype=np.float64))
    if isinstance(cloud, FitFailure):
        return cloud
    sample = _sampled(cloud, SAMPLE)
    normals = estimate_normals(sample)
    fits = [_fitted(make, sample, normals) for make in MODELS.values()]
    found = sorted((c for c in fits if isinstance(c, Candidate)), key=lambda one: one.bic)
    return tuple(found) or FitFailure("no solid fits the points")


def from_points(shape: str, points: ArrayLike) -> Candidate | FitFailure:
    """Fit one shape, a key of `MODELS`, to points (N, 3); a cone may come out truncated."""
    if shape not in MODELS:
        raise InputError(f"shape is {shape!r}, but one of {', '.join(MODELS)} is needed")
    cloud = _usable(np.asarray(points, dtype=np.float64))
    if isinstance(cloud, FitFailure):
        return cloud
    sample = _sampled(cloud, LARGE_SAMPLE)
    return _fitted(MODELS[shape], sample, estimate_normals(sample))


def _usable(points: Array) -> Array | FitFailure:
    check_shape("points", points, (None, 3))
    num_bad = int((~np.isfinite(points).all(axis=1)).sum())
    if num_bad:
        return FitFailure(f"{num_bad} of {len(points)} points are not finite")
    distinct = np.unique(points, axis=0)
    if len(distinct) < 4:
        return FitFailure(f"{len(distinct)} distinct points are too few; 4 are needed")
    spread = np.linalg.svd(distinct - distinct.mean(axis=0), compute_uv=False)
    if spread[1] < 1e-6 * spread[0]:
        return FitFailure("the points lie on one line")
    return points


def _sampled(points: Array, most: int) -> Array:
    if len(points) <= most:
        return points
    return points[np.random.default_rng(0).choice(len(points), most, replace=False)]


def _fitted(make: Callable[[Array], Any], points: Array, normals: Array) -> Candidate | FitFailure:
    model = make(points)
    spare = len(points) - model.num_parameters - 1
    if spare < 1:
        return FitFailure("too few points for the shape")
    floor = RELATIVE_FLOOR * float(np.sqrt(points.var(axis=0).sum()))
    rough = [minimise(model, start, floor=floor, max_steps=5) for start in model.starts(normals)]
    best = min(rough, key=lambda estimate: estimate.deviance)
    estimate = minimise(model, best.state, floor=floor)
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


MODELS: dict[str, Callable[[Array], Any]] = {
    "sphere": SphereModel,
    "ellipsoid": EllipsoidModel,
    "cylinder": partial(AxialModel, is_cone=False),
    "cone": partial(AxialModel, is_cone=True),
    "plane": PlaneModel,
    "box": BoxModel,
}
