"""Fit of one solid to a cloud with many outliers.

The fit to all points tolerates 10 % gross outliers (`shapes`). If half of the points or more vote
for one solid, and fit it far more tightly, that solid is used instead.
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
"""Share of the points that a voted solid must explain: otherwise another part could explain as
many."""
TIGHTER = 0.5
"""A voted solid must have an rms below this share of that of the fit to all points."""
RMS_EXPLAINED = 3.0
"""Points within this multiple of the rms are explained."""
NEARLY_ALL = 0.95
"""Share of explained points from which the outliers are too few to bias the fit."""
NUM_ROUNDS = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explained:
    """Candidate solids for a cloud, and how much of it the best explains."""

    candidates: tuple[Candidate, ...]
    """Best first; rms and bic refer to the points they were fitted to."""
    rms: float
    """Root mean square distance of the explained points from the best."""
    share: float
    """Share of all points within 3 rms of the best."""


def fit(points: ArrayLike) -> Solid | FitFailure:
    """The solid that most of the points (N, 3) lie on; a falsy reason if there is none.

    Raises
    ------
    InputError
        If `points` is not an array of numbers of that shape.
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
    """The solids fitted again to the explained points only, without the bias of outliers."""
    inside = found.candidates[0].solid.distances(points) <= RMS_EXPLAINED * found.rms
    again = candidates(points[inside])
    return found if isinstance(again, FitFailure) else _explained(again, points)


def _voted(points: Array) -> Explained | None:
    """The solids of the points that vote for one; None if fewer than half do."""
    least = max(int(LEAST_SHARE * len(points)), 1)
    solids = find_solids(points, least, np.random.default_rng(0), most=1)
    found = (
        candidates(points[solids[0].rows])
        if solids
        else FitFailure("no half of the points lies on a solid")
    )
    return None if isinstance(found, FitFailure) else _explained(found, points)


def _is_tighter(voted: Explained, first: Explained) -> bool:
    return voted.share >= LEAST_SHARE and voted.rms < TIGHTER * first.rms


def _explained(found: tuple[Candidate, ...], points: Array) -> Explained:
    """Iterate the rms and the points within 3 rms of the best solid until both agree."""
    away = found[0].solid.distances(points)
    inside = away <= INLIER_SIGMAS * found[0].sigma
    for _ in range(NUM_ROUNDS):
        rms = float(np.sqrt(np.mean(away[inside] ** 2))) if inside.any() else found[0].rms
        inside = away <= RMS_EXPLAINED * rms
    return Explained(candidates=found, rms=rms, share=float(inside.mean()))
