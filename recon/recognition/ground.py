"""Where the ground is."""

import numpy as np

from recon.records import Voxels
from recon.settings import RecognitionSettings


def ground_height(voxels: Voxels, settings: RecognitionSettings) -> float:
    """Height of the ground, world: as set, else that of the fullest layer of the lower half."""
    if settings.ground is not None:
        return settings.ground
    if not len(voxels):
        return 0.0
    layers, counts = np.unique(voxels.index[:, 1], return_counts=True)
    low = layers <= (layers[0] + layers[-1]) / 2
    fullest = layers[low][np.argmax(counts[low])]
    return float(np.median(voxels.means[voxels.index[:, 1] == fullest, 1]))
