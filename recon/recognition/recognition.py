"""From occupied cells to named objects (thesis 4.5)."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from recon.recognition.catalogue import read_catalogue
from recon.recognition.components import connected, in_order_of_appearance
from recon.recognition.ground import ground_height
from recon.recognition.naming import Naming, name_object
from recon.records import Recognition, Voxels
from recon.settings import RecognitionSettings

GAP_REACH = 2
"""Cells of one object lie at most so many apart: gaps of one cell are closed."""


def recognise(voxels: Voxels, settings: RecognitionSettings) -> Recognition:
    """Find and name the objects of a map.

    Parameters
    ----------
    voxels : Voxels
        Occupied cells, world, y up.

    Returns
    -------
    Recognition
        Objects numbered by their place (x, then z), a label for each cell handed in, and failures
        counted by reason.
    """
    instance = components(voxels, settings)
    ground = ground_height(voxels, settings)
    kinds = read_catalogue()
    failures: Counter[str] = Counter()
    named: list[tuple[Naming, NDArray[np.bool_]]] = []
    for number in range(int(instance.max(initial=-1)) + 1):
        rows = instance == number
        if rows.sum() < settings.min_voxels:
            failures[f"fewer than {settings.min_voxels} cells"] += 1
            continue
        naming = name_object(voxels.select(rows), ground, kinds)
        failures.update(naming.failures)
        named.append((naming, rows))
    return _numbered(named, len(voxels), failures)


def components(voxels: Voxels, settings: RecognitionSettings) -> NDArray[np.int32]:
    """Number of the object each cell belongs to after the ground is taken off.

    Returns
    -------
    instance : (K,) int32
        0, 1, ...; -1 = ground. Objects too small to be named are numbered too.
    """
    ground = ground_height(voxels, settings)
    above = voxels.centres[:, 1] >= ground + settings.ground_clearance
    instance = np.full(len(voxels), -1, dtype=np.int32)
    instance[above] = connected(voxels.index[above], GAP_REACH)
    return in_order_of_appearance(instance)


def _numbered(
    named: list[tuple[Naming, NDArray[np.bool_]]], num_cells: int, failures: Counter[str]
) -> Recognition:
    named = sorted(named, key=lambda pair: (pair[0].centre[0], pair[0].centre[2]))
    label = np.full(num_cells, -1, dtype=np.int32)
    objects = []
    for number, (naming, rows) in enumerate(named):
        label[rows] = number
        objects.append(naming.found(number, int(rows.sum())))
    return Recognition(objects=tuple(objects), label=label, failures=dict(failures))
