"""A recogniser without a catalogue: what is higher than wide is a tower."""

import numpy as np

import recon
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.naming import Naming
from recon.settings import RecognitionSettings


def by_height(
    cells: recon.Voxels, ground: float, kinds: tuple[Kind, ...], settings: RecognitionSettings
) -> Naming:
    """Name an object by its box alone."""
    low, high = cells.means.min(axis=0), cells.means.max(axis=0)
    low[1] = ground
    size = high - low
    label = "tower" if size[1] > max(size[0], size[2]) else "block"
    return Naming(label=label, probability=1.0, centre=np.add(low, high) / 2.0, size=size)
