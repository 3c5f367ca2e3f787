"""What colour says about a fit that shape has made: whether the parts part where the colours do."""

import numpy as np

from recon.recognition.fitting.composite import Stack, StackModel
from recon.recognition.segments.segmentation import split_colours
from recon.records import FitFailure, Voxels

WEIGHT = 10.0
"""Cells that colour counts for: it decides between fits alike, never against shape."""


def colour_opinions(stacks: list[Stack], voxels: Voxels) -> list[float]:
    """Log evidence for each stack; 0 for the best, and for all where the colours do not part.

    Parameters
    ----------
    stacks : list of Stack
        Fits of the same cells.
    """
    segments = split_colours(voxels)
    if isinstance(segments, FitFailure) or not stacks:
        return [0.0] * len(stacks)
    model = StackModel(voxels.means)
    above = [model.nearest(stack)[2] > 0 for stack in stacks]
    shares = [float(np.mean(upper == (segments.label == 1))) for upper in above]
    return [WEIGHT * float(np.log((0.1 + share) / (0.1 + max(shares)))) for share in shares]
