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
from recon.recognition.fitting.least_squares import minimise, most_promising
from recon.recognition.fitting.round_shapes import EllipsoidModel, SphereModel
from recon.recognition.fitting.sample import Sample
from recon.records import FitFailure, Solid

Array = NDArray[np.float64]

SAMPLE = 800
"""Points used to choose a shape: more do not change the choice."""
LARGE_SAMPLE = 10_000
"""Points used to refine the chosen solid."""
FEW = 8
"""Points that are looked at first for enough distinct ones."""
SURE_SPREAD = 1e-6
"""Share of the variance in a second direction above which squares are exact enough to tell."""
RELATIVE_FLOOR = 1e-4
"""Minimum noise as a share of the cloud's size, because of facets and rounding."""
AS_GOOD = 0.1
"""Fits whose BIC per point differs by less (5 percent of noise), or whose BIC differs by less than
one parameter, are equally good: errors of cells and facets are correlated, which a criterion over
single points ignores."""
ROUGH_STEPS = 4
"""Steps used to choose the most promising start."""
SMALLEST, LARGEST = 1e-60, 1e60
"""Extent and coordinates whose fourth powers are still finite and nonzero."""
INLIER_SIGMAS = 4.0
"""Points within this number of scales are on a fit and define its ends."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate:
    """One solid fitted to points."""

    solid: Solid
    points: Array
    """(N, 3) that it was fitted to."""
    bic: float
    """The smallest is best; only comparable for the same points."""
    sigma: float
    """Scale of the noise without outliers."""
    information: Array
    """(P, P) inverse covariance of the surface's parameters, in the order of its model's steps."""

    @property
    def rms(self) -> float:
        """Root mean square of the geometric distances of all points, in their unit."""
        return float(np.sqrt(np.mean(self.solid.distances(self.points) ** 2)))

    @property
    def covariance(self) -> Array:
        """Covariance (P, P) of the surface's parameters."""
        return np.linalg.pinv(self.information, hermitian=True).astype(np.float64)


def fit(points: ArrayLike, weights: ArrayLike | None = None) -> Solid | FitFailure:
    """The solid that points lie on.

    Parameters
    ----------
    points : (N, 3) array_like
        In any frame and unit; neither affects the shape found.
    weights : (N,) array_like, optional
        Weight of each point, such as the number of points in a cell.

    Returns
    -------
    Solid or FitFailure
        The candidate with the smallest BIC; a falsy reason if no solid fits the points.
    """
    found = candidates(points, weights)
    return found if isinstance(found, FitFailure) else found[0].solid


def candidates(
    points: ArrayLike, weights: ArrayLike | None = None
) -> tuple[Candidate, ...] | FitFailure:
    """Every solid that can be fitted to points (N, 3), best first."""
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
    """Fit one shape, a key of `MODELS`, to points (N, 3); a cone may be truncated."""
    if shape not in MODELS:
        raise InputError(f"shape is {shape!r}, but one of {', '.join(MODELS)} is needed")
    sample = _sample(points, weights, LARGE_SAMPLE)
    return sample if isinstance(sample, FitFailure) else _fitted(MODELS[shape], sample)


def _sample(points: ArrayLike, weights: ArrayLike | None, most: int) -> Sample | FitFailure:
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
    return Sample(points=np.ascontiguousarray(cloud), weights=share)


def _fault(points: Array) -> str:
    """The reason why no solid can be fitted to the points; empty if one can."""
    num_bad = int((~np.isfinite(points).all(axis=1)).sum())
    if num_bad:
        return f"{num_bad} of {len(points)} points are not finite"
    num_distinct = _num_distinct(points)
    if num_distinct < 4:
        return f"{num_distinct} distinct points are too few; 4 are needed"
    extent = float(np.ptp(points, axis=0).max())
    if not (extent > SMALLEST and np.abs(points).max() < LARGEST):
        return f"the points span {extent:g}, outside the computable range"
    if _are_on_a_line(points):
        return "the points lie on one line"
    return ""


def _are_on_a_line(points: Array) -> bool:
    """True if points (N, 3) spread in one direction only."""
    local = points - points.mean(axis=0)
    _, middle, most = np.linalg.eigvalsh(local.T @ local)
    if middle > SURE_SPREAD * most:
        return False
    spread = np.linalg.svd(local, compute_uv=False)
    return bool(spread[1] < 1e-6 * spread[0])


def _num_distinct(points: Array) -> int:
    """Number of distinct points, of the first few that are enough if these are."""
    few = len(set(map(tuple, points[:FEW].tolist())))
    return few if few >= 4 else len(np.unique(points, axis=0))


def _fitted(make: Callable[[Sample], Any], sample: Sample) -> Candidate | FitFailure:
    points, share, model = sample.points, sample.share, make(sample)
    spare = len(points) - model.num_parameters - 1
    if spare < 1:
        return FitFailure("too few points for the shape")
    floor = RELATIVE_FLOOR * sample.size
    start = most_promising(
        model.surface, points, model.starts(), share=share, floor=floor, num_steps=ROUGH_STEPS
    )
    estimate = minimise(model.surface, points, start, share=share, floor=floor)
    inliers = points[np.abs(estimate.residuals) <= INLIER_SIGMAS * estimate.sigma]
    solid = model.solid(estimate.state, inliers, estimate.sigma)
    if isinstance(solid, FitFailure):
        return solid
    # Correction for few points as in AICc.
    penalty = model.num_parameters * np.log(len(points)) * len(points) / spare
    return Candidate(
        solid=solid,
        points=points,
        bic=estimate.deviance + float(penalty),
        sigma=estimate.sigma,
        information=estimate.information,
    )


# The first of equally good fits is chosen.
MODELS: dict[str, Callable[[Sample], Any]] = {
    "plane": PlaneModel,
    "cylinder": partial(AxialModel, is_cone=False),
    "sphere": SphereModel,
    "cone": partial(AxialModel, is_cone=True),
    "ellipsoid": EllipsoidModel,
    "box": BoxModel,
}
