"""By how much a whole fit is better than the lone solids that are its rivals."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Composite, CompositeModel
from recon.recognition.fitting.least_squares import Estimate, deviance_a_residual
from recon.recognition.fitting.shapes import Candidate
from recon.records import Voxels

Array = NDArray[np.float64]

ENOUGH_CELLS = 10
"""Cells of a part from which its own lead means something."""
OF_ONE_PART = 0.25
"""Weight of the lead on the cells of one part: it is the largest of several."""


def lead_of_parts(fit: Estimate[Composite], cells: Voxels, rivals: Sequence[Candidate]) -> float:
    """Largest lead that a fit has on the cells of one part over all rivals, per cell, weighted.

    The walls of a cottage lie on a lone cylinder as well; what tells it is that its roof does not,
    however few of the cells are on it.
    """
    signed, _, part = CompositeModel(cells.means).nearest(fit.state)
    own = deviance_a_residual(signed, fit.sigma)
    others = [deviance_a_residual(one.solid.distances(cells.means), one.sigma) for one in rivals]
    counts = np.bincount(part)
    enough = counts >= ENOUGH_CELLS
    if not others or not enough.any():
        return -np.inf
    means = [np.bincount(part, other - own)[enough] / counts[enough] for other in others]
    return OF_ONE_PART * float(np.min(means, axis=0).max())
