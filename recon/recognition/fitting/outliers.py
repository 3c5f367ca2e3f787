"""One solid to a cloud of which much may lie elsewhere.

The fit to all points bears a tenth of gross outliers (`shapes`). Where the solid that most points
vote for is hit by half of them or more, and far more tightly, it is what the cloud shows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import as_numbers, check_shape
from recon.recognition.fitting.ransac import find_solids
from recon.recognition.fitting.shapes import INLIER_SIGMAS, Candidate, candidates
from recon.records import FitFailure, Solid

Array = NDArray[np.float64]

LEAST_SHARE = 0.5
"""Of the points that a voted solid has to explain: otherwise another part could do as much."""
TIGHTER = 0.5
"""Of the scale of the fit to all points: a voted solid has to lie within less."""
RMS_EXPLAINED = 3.0
"""Points nearer than so many rms are explained."""
NEARLY_ALL = 0.95
"""Of the points: so few outliers pull nothing."""
NUM_ROUNDS = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explained:
    """The solids that could be in a cloud, and how much of it the best explains."""

    candidates: tuple[Candidate, ...]
    """The best first; rms and bic are those of the points they were fitted to."""
    rms: float
    """Root mean square of the distances of the explained points to the best."""
    share: float
    """Of all points, those within 3 rms of the best."""


def fit(points: ArrayLike) -> Solid | FitFailure:
    """The solid that most of the points (N, 3) lie on; a falsy reason where they show none.

    Raises
    ------
    InputError
        Where `points` is not an array of numbers of that shape.
    """
    numbers = as_numbers("points", points)
    check_shape("points", numbers, (None, 3))
    found = explain(numbers)
    return found if isinstance(found, FitFailure) else found.candidates[0].solid


def explain(points: Array) -> Explained | FitFailure:
    """The solid that most of the points (N, 3) lie on, and how many of them do."""
    to_all = candidates(points)
    if isinstance(to_all, FitFailure):
        return to_all
    first = _explained(to_all, points)
    voted = _voted(points)
    best = first if voted is None or not _is_tighter(voted, first) else voted
    return best if best.share >= NEARLY_ALL else _refitted(best, points)


def _refitted(found: Explained, points: Array) -> Explained:
    """The same with the solids fitted to the explained points alone, which outliers do not pull."""
    inside = found.candidates[0].solid.distances(points) <= RMS_EXPLAINED * found.rms
    again = candidates(points[inside])
    return found if isinstance(again, FitFailure) else _explained(again, points)


def _voted(points: Array) -> Explained | None:
    """The same of the points that vote for one solid; None where no half of them does."""
    least = max(int(LEAST_SHARE * len(points)), 1)
    solids = find_solids(points, least, np.random.default_rng(0), most=1)
    found = candidates(points[solids[0].rows]) if solids else FitFailure("no half lies on a solid")
    return None if isinstance(found, FitFailure) else _explained(found, points)


def _is_tighter(voted: Explained, first: Explained) -> bool:
    return voted.share >= LEAST_SHARE and voted.rms < TIGHTER * first.rms


def _explained(found: tuple[Candidate, ...], points: Array) -> Explained:
    """The rms and the points within 3 of it that the best explains, until both agree."""
    away = found[0].solid.distances(points)
    inside = away <= INLIER_SIGMAS * found[0].sigma
    for _ in range(NUM_ROUNDS):
        rms = float(np.sqrt(np.mean(away[inside] ** 2))) if inside.any() else found[0].rms
        inside = away <= RMS_EXPLAINED * rms
    return Explained(candidates=found, rms=rms, share=float(inside.mean()))
