"""Candidates: the poses that a pair may have, and the one that wins."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from scipy.special import logsumexp

from recon.geometry import wrapped
from recon.localisation.graph import planar
from recon.records import FitFailure, PoseEstimate

APART_CELLS, APART_RAD = 0.6, 0.05
"""Distance, and difference of heading, from which on poses are distinct."""
NUM_SIGMAS = 3.0
"""Poses that differ by fewer standard deviations are the same."""
COVERED_SHARE, COVERED_COSINE = 0.35, 0.94
"""A place covers a pose within this share of its depth and 20 degrees: features would have found
it."""
CHANCE = 6.0
"""Agreement that chance may have."""
MIN_PROBABILITY, MAX_SIGMA_CELLS, MIN_SHARE = 0.99, 0.3, 0.5
"""Of an accepted pose: probability, standard deviation, and share of the points on the map."""


class Possibility(Protocol):
    """Anything with a likelihood."""

    @property
    def evidence(self) -> float:
        """Logarithm of the likelihood."""


T = TypeVar("T", bound=Possibility)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate:
    """A pose that may be the true one."""

    estimate: PoseEstimate
    evidence: float
    """Logarithm of its likelihood, up to a constant of the pair."""
    is_known: bool = False
    """True if it is measured by the features of a known place."""
    reach: float = 0.0
    """Distance within which features would have found another pose, world units."""

    def is_covered(self, by: "Candidate") -> bool:
        """True if the features that measured another pose would have measured this one."""
        own, other = (one.estimate.T_world_left for one in (self, by))
        is_near = np.linalg.norm(own[:3, 3] - other[:3, 3]) < by.reach
        return bool(by.is_known and is_near and own[:3, 2] @ other[:3, 2] > COVERED_COSINE)

    def is_apart(self, better: "Candidate", cell_size: float) -> bool:
        """True if this is another pose than a better one, beyond the uncertainty of that."""
        own, other = (planar(one.estimate.T_world_left) for one in (self, better))
        turn, off = abs(float(wrapped(own[2] - other[2]))), math.hypot(*(own - other)[:2])
        of = better.estimate
        return off > max(APART_CELLS * cell_size, NUM_SIGMAS * of.sigma) or turn > max(
            APART_RAD, NUM_SIGMAS * math.radians(of.sigma_deg)
        )


def distinct(found: list[Candidate], cell_size: float) -> list[Candidate]:
    """The distinct candidates, the likeliest first.

    Where shape leaves a pose open, as that of a round thing seen alone, a known place that shows
    the same tells it.
    """
    kept = merged(found, lambda one, other: not one.is_apart(other, cell_size), _told)
    return [one for row, one in enumerate(kept) if not any(one.is_covered(by) for by in kept[:row])]


def _told(kept: Candidate, one: Candidate) -> Candidate:
    """A kept candidate, at the pose of a known place if that is more precise."""
    is_better = one.is_known and one.estimate.sigma < kept.estimate.sigma
    return replace(one, evidence=kept.evidence) if is_better else kept


def merged(
    found: Iterable[T], is_same: Callable[[T, T], bool], merge: Callable[[T, T], T]
) -> list[T]:
    """The distinct possibilities, the likeliest first.

    Parameters
    ----------
    found : iterable
    is_same : callable
        True if a possibility is the same as a likelier one.
    merge : callable
        Unites a kept possibility with another one that is the same.
    """
    kept: list[T] = []
    for one in sorted(found, key=lambda one: -one.evidence):
        row = next((row for row, other in enumerate(kept) if is_same(one, other)), None)
        if row is None:
            kept.append(one)
        else:
            kept[row] = merge(kept[row], one)
    return kept


def decide(
    found: list[Candidate], cell_size: float, chance: float = CHANCE
) -> PoseEstimate | FitFailure:
    """The likeliest of distinct candidates, likeliest first, if no other comes near it."""
    if not found:
        return FitFailure("no place looks like it")
    best = found[0].estimate
    evidence = np.array([*(one.evidence for one in found), chance])
    probability = float(np.exp(evidence[0] - logsumexp(evidence)))
    if best.inlier_share < MIN_SHARE:
        return FitFailure("the map shows other things there")
    if probability < MIN_PROBABILITY:
        return FitFailure("several places look like it" if len(found) > 1 else "too little is seen")
    return exact(replace(best, probability=probability), MAX_SIGMA_CELLS * cell_size)


def exact(found: PoseEstimate | FitFailure, max_sigma: float) -> PoseEstimate | FitFailure:
    """A pose, if the standard deviation of its position is at most `max_sigma`, world units."""
    if isinstance(found, PoseEstimate) and found.sigma > max_sigma:
        return FitFailure("too little is seen to tell the exact place")
    return found
