"""Colour as evidence on a fit that shape has made: parts must part where colours do."""

import numpy as np

from recon.recognition.fitting.composite import Composite, CompositeModel
from recon.recognition.segments.segmentation import split_colours
from recon.records import FitFailure, Voxels

WEIGHT = 10.0
"""Cells that colour counts for: it decides between fits alike, never against shape."""


def colour_opinions(composites: list[Composite], voxels: Voxels) -> list[float]:
    """Log evidence for each composite; 0 for the best, and for all where the colours do not part.

    Parameters
    ----------
    composites : list of Composite
        Fits of the same cells.
    """
    segments = split_colours(voxels)
    if isinstance(segments, FitFailure) or not composites:
        return [0.0] * len(composites)
    model = CompositeModel(voxels.means)
    above = [model.nearest(composite)[2] > 0 for composite in composites]
    shares = [float(np.mean(upper == (segments.label == 1))) for upper in above]
    return [WEIGHT * float(np.log((0.1 + share) / (0.1 + max(shares)))) for share in shares]
