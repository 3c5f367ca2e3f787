"""Colour as additional evidence for a fit by shape: parts should meet where colours change."""

import numpy as np

from recon.recognition.fitting.composite import Composite
from recon.records import FitFailure, Segments, Voxels

WEIGHT = 10.0
"""Weight of colour in cells: it decides between similar fits, never against shape."""


def colour_opinions(
    composites: list[Composite], voxels: Voxels, split: Segments | FitFailure
) -> list[float]:
    """Log evidence for each composite; 0 for the best, and for all if the colours do not split.

    Parameters
    ----------
    composites : list of Composite
        Fits of the same cells.
    split : Segments or FitFailure
        The cells' two parts by colour.
    """
    if isinstance(split, FitFailure):
        return [0.0] * len(composites)
    above = [composite.nearest(voxels.means)[1] > 0 for composite in composites]
    shares = [float(np.mean(upper == (split.label == 1))) for upper in above]
    return [WEIGHT * float(np.log((0.1 + share) / (0.1 + max(shares)))) for share in shares]
