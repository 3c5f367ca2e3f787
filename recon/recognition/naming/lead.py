"""Lead of a composite fit over competing single solids, and over parts of other shapes."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Composite
from recon.recognition.fitting.least_squares import Estimate, deviance_a_residual
from recon.recognition.fitting.shapes import Candidate
from recon.records import Voxels

Array = NDArray[np.float64]

ENOUGH_CELLS = 10
"""Minimum number of cells of a part for a meaningful lead."""
BLUR = 0.04
"""Square of the noise, in that of a formless object, by which fits are blurred before they compete:
finer differences come of cells, whose means are off by a tenth of a cell."""
OF_ONE_PART = 0.25
"""Weight of the lead on one part, since it is the maximum of several."""


def lead_of_parts(fit: Estimate[Composite], cells: Voxels, rivals: Sequence[Candidate]) -> float:
    """Largest weighted lead of a fit over all rivals on the typical cell of one part.

    A single cylinder fits the walls of a cottage as well, but not its roof, which therefore decides
    even if it has few cells.
    """
    signed, part = fit.state.nearest(cells.means)
    own = deviance_a_residual(signed, fit.sigma)
    others = [deviance_a_residual(one.solid.distances(cells.means), one.sigma) for one in rivals]
    enough = np.flatnonzero(np.bincount(part) >= ENOUGH_CELLS)
    if not others or not len(enough):
        return -np.inf
    # Of the median: a roof is not made by the few cells that are off the rim of a post.
    leads = [[np.median((other - own)[part == one]) for one in enough] for other in others]
    return OF_ONE_PART * float(np.min(leads, axis=0).max())


def lead_over_shapes(
    shapes: tuple[str, ...],
    of_kind: Collection[tuple[str, ...]],
    criteria: Mapping[tuple[str, ...], float],
) -> float:
    """Lead of the fit of some shapes over the best one of shapes that its kind does not have.

    Parameters
    ----------
    criteria : mapping of tuple of str to float
        BIC per cell of each fit, minus that of a formless object: twice the log of the noise.
    """
    others = [criterion for other, criterion in criteria.items() if other not in of_kind]
    own, rival = np.exp(criteria[shapes]), np.exp(min(others, default=np.inf))
    return float(np.log((rival + BLUR) / (own + BLUR)))
