"""Relocation: the pose of a pair by the landmarks of a run, as far as they prove to be reliable.

Each of some images of the run is located by the landmarks of the others first: where textures
repeat, it is found elsewhere, and landmarks say nothing; how far off it is calibrates sigma.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.special import logsumexp

from recon.geometry import Array
from recon.localisation.landmarks import Landmarks, landmarks_of
from recon.localisation.registration import Prior, inverse
from recon.localisation.resection import MIN_START, Resection, Start, resected, started
from recon.localisation.sights import Sight, sight_of, sights_of
from recon.records import FitFailure, PoseEstimate, StereoPair

NUM_CANDIDATES, NUM_REFINED = 12, 4
"""Images that look most alike, and different poses by them that are refined."""
SAME_SHARE = 0.05
"""Poses within this share of the depth, and an angle of as many radians, are one."""
CHANCE, POINTS_PER_E = 60.0, 2.0
"""Landmarks that may agree on a pose that is off, as outlines of round things do, which are not the
same points from two sides; and number of more of them that make a pose e times as likely."""
MIN_SHARE = 0.5
"""Least share of the landmarks near features that agree."""
MIN_PROBABILITY = 0.99
MAX_SIGMA_SHARE = 0.005
"""Greatest standard deviation of the position by landmarks without errors, as a share of the
depth."""
NUM_TESTED = 8
RIGHT_SHARE = 0.2
"""Greatest error of an image that is found where it was taken, as a share of the depth."""
MIN_TRUST = math.log(10.0)
"""Least log odds that what is found is right."""


T = TypeVar("T", Start, Resection)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """Result of locating images of the run by the landmarks of the others."""

    trust: float
    """Log odds that they are found where they were taken."""
    spread: float
    """Errors of what is found right, in standard deviations: poses of a run have errors, too."""


class Relocation:
    """Finds pairs by the landmarks of a run.

    Parameters
    ----------
    pairs : sequence of StereoPair
        Pairs of the run, at its poses.
    """

    def __init__(self, pairs: Sequence[StereoPair]) -> None:
        self._pairs = pairs

    def recall(self, pair: StereoPair) -> PoseEstimate | FitFailure:
        """The pose of a pair; a failure if landmarks do not determine it."""
        if self._trial.trust < MIN_TRUST:
            return FitFailure("several places look like it")
        found = located(sight_of(replace(pair, T_world_left=None)), self._known)
        if isinstance(found, FitFailure):
            return found
        return replace(found, covariance=self._trial.spread**2 * found.covariance)

    @cached_property
    def _known(self) -> list[Landmarks]:
        """The landmarks of the run; computed when they are needed first."""
        if len(self._pairs) < 2:
            return []
        return [one for one in landmarks_of(sights_of(self._pairs)) if len(one) >= MIN_START]

    @cached_property
    def _trial(self) -> Trial:
        rows = np.unique(np.linspace(0, len(self._known) - 1, NUM_TESTED).astype(np.intp))
        tested = [self._known[row] for row in rows if self._known]
        found = [(one, located(one.sight, self._others(one.sight))) for one in tested]
        off = [_off(one, there) for one, there in found if isinstance(there, PoseEstimate)]
        right = [chi_sq for chi_sq, is_right in off if is_right]
        odds = (len(right) + 0.5) / (len(off) - len(right) + 0.5)
        spread = math.sqrt(sum(right) / len(right)) if right else 1.0
        return Trial(trust=math.log(odds), spread=max(1.0, spread))

    def _others(self, sight: Sight) -> list[Landmarks]:
        """The landmarks of other pairs."""
        return [one for one in self._known if one.sight.number != sight.number]


def _off(true: Landmarks, found: PoseEstimate) -> tuple[float, bool]:
    """Mean squared error of a pose in standard deviations, and whether it is the right place."""
    known = Prior(T_world_left=true.sight.T_world_camera, information=inverse(found.covariance))
    off = known.pull(found.T_world_left)
    is_right = bool(np.linalg.norm(off[3:]) < RIGHT_SHARE * true.depth)
    return float(off @ known.information @ off) / len(off), is_right


def located(query: Sight, known: Sequence[Landmarks]) -> PoseEstimate | FitFailure:
    """The pose of an image among landmarks; a failure if they do not determine it."""
    found = [resected(query, known, start) for start in _starts(query, known)]
    kept = _distinct([one for one in found if one is not None])
    if not kept:
        return FitFailure("no place looks like it")
    best = kept[0]
    evidence = np.array([*((one.num_agreeing - CHANCE) / POINTS_PER_E for one in kept), 0.0])
    probability = float(np.exp(evidence[0] - logsumexp(evidence)))
    if best.num_agreeing < MIN_SHARE * best.num_near:
        return FitFailure("the map shows other things there")
    if probability < MIN_PROBABILITY:
        return FitFailure("several places look like it" if len(kept) > 1 else "too little is seen")
    estimate = PoseEstimate(
        T_world_left=best.T_world_camera, covariance=best.covariance, probability=probability,
        residual=1.0, inlier_share=best.num_agreeing / best.num_near, num_cells=0,
    )  # fmt: skip
    if estimate.sigma > MAX_SIGMA_SHARE * best.depth:
        return FitFailure("too little is seen to tell the exact place")
    return estimate


def _starts(query: Sight, known: Sequence[Landmarks]) -> list[Array]:
    """Approximate poses by the images that look most alike, the surest first."""
    if not len(query):
        return []
    summary = query.summary
    likeness = np.array([one.sight.summary @ summary for one in known])
    nearest = np.argsort(-likeness, kind="stable")[:NUM_CANDIDATES]
    found = [one for row in nearest if (one := started(query, known[row])) is not None]
    return [one.T_world_camera for one in _distinct(found)[:NUM_REFINED]]


def _distinct(found: Sequence[T]) -> list[T]:
    """One of the poses that are the same, the surest first."""
    kept: list[T] = []
    for one in sorted(found, key=lambda one: -one.num_agreeing):
        if not any(_is_same(one, other) for other in kept):
            kept.append(one)
    return kept


def _is_same(one: Start | Resection, other: Start | Resection) -> bool:
    own, known = one.T_world_camera, other.T_world_camera
    is_near = np.linalg.norm(own[:3, 3] - known[:3, 3]) < SAME_SHARE * other.depth
    return bool(is_near and own[:3, 2] @ known[:3, 2] > math.cos(SAME_SHARE))
