"""Contest: the poses that a pair may have, compared two by two.

A pose is not better because the map shows more of what is seen there: an unseen side may look the
same. It is better where another pose is contradicted: by shape, by texture, by what is missing.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.localisation.search import MAX_SIGMA_CELLS, MIN_PROBABILITY, MIN_SHARE, Candidate
from recon.localisation.texture import Likeness
from recon.records import FitFailure, PoseEstimate

Array = NDArray[np.float64]

SHAPE_WEIGHT = 0.25
"""Weight of the evidence of shape: the sides of a map differ in quality."""
MOST_PER_TILE = 1.0
"""Most that agreement in one tile of the image counts: how well it agrees depends on the map."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contender(Candidate):
    """A pose with the evidence of its shape and its texture."""

    likeness: Likeness

    @property
    def strength(self) -> float:
        """Evidence by which contenders are sorted."""
        return SHAPE_WEIGHT * self.evidence + self.likeness.total

    def over(self, other: "Contender") -> float:
        """Log odds of this pose over another."""
        mine, theirs = self.likeness, other.likeness
        contradicted = np.minimum(mine.evidence, 0.0) - np.minimum(theirs.evidence, 0.0)
        agreeing = [one.evidence.clip(0.0, MOST_PER_TILE) for one in (mine, theirs)]
        both = mine.is_covered & theirs.is_covered
        texture = contradicted.sum() + (agreeing[0] - agreeing[1])[both].sum()
        return float(SHAPE_WEIGHT * (self.evidence - other.evidence) + texture)


def decide(found: list[Contender], cell_size: float) -> PoseEstimate | FitFailure:
    """The pose that wins against every other; a `FitFailure` if none does clearly."""
    if not found:
        return FitFailure("no place looks like it")
    best = distinct(found, cell_size)
    odds = np.array([[one.over(other) for other in best] for one in best])
    np.fill_diagonal(odds, np.inf)
    winner = int(odds.min(axis=1).argmax())
    np.fill_diagonal(odds, 0.0)
    probability = float(1.0 / np.exp(-odds[winner]).sum())
    estimate = best[winner].estimate
    if estimate.inlier_share < MIN_SHARE:
        return FitFailure("the map shows other things there")
    if probability < MIN_PROBABILITY:
        return FitFailure("several places look like it")
    if estimate.sigma > MAX_SIGMA_CELLS * cell_size:
        return FitFailure("too little is seen to tell the exact place")
    return replace(estimate, probability=probability)


def distinct(found: list[Contender], cell_size: float) -> list[Contender]:
    """The distinct contenders, the strongest of those that are the same pose."""
    kept: list[Contender] = []
    for one in sorted(found, key=lambda one: -one.strength):
        if all(one.is_apart(other, cell_size) for other in kept):
            kept.append(one)
    return kept
