"""From occupied cells to named objects (thesis 4.5)."""

from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.recognition.catalogue import Kind, read_catalogue
from recon.recognition.components import connected, stacked
from recon.recognition.ground import ground_height
from recon.recognition.naming import Naming, name_object
from recon.recognition.separation import separate
from recon.recognition.thesis import name_by_quadrics
from recon.records import Recognition, Voxels
from recon.settings import RecognitionSettings

Named = tuple[Naming, NDArray[np.intp]]

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

    Raises
    ------
    InputError
        Where the catalogue cannot be read.
    """
    kinds = read_catalogue(None if settings.catalogue is None else Path(settings.catalogue))
    ground = ground_height(voxels, settings)
    instance = components(voxels, settings)
    failures: Counter[str] = Counter()
    named: list[Named] = []
    for number in range(int(instance.max(initial=-1)) + 1):
        rows = np.flatnonzero(instance == number)
        if len(rows) < settings.min_voxels:
            failures[f"fewer than {settings.min_voxels} cells"] += 1
        else:
            named.extend(_name(voxels, rows, ground, kinds, settings))
    for naming, _ in named:
        failures.update(naming.failures)
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
    label = connected(voxels.index[above], GAP_REACH)
    instance = np.full(len(voxels), -1, dtype=np.int32)
    instance[above] = stacked(voxels.means[above], label, settings.min_voxels)
    return instance


def _name(
    voxels: Voxels,
    rows: NDArray[np.intp],
    ground: float,
    kinds: tuple[Kind, ...],
    settings: RecognitionSettings,
) -> list[Named]:
    """The objects of one component, each with its rows."""
    cells = voxels.select(rows)
    if settings.recogniser == "thesis":
        return [(name_by_quadrics(cells, ground, kinds, settings.hue_tolerance_deg), rows)]
    whole = name_object(cells, ground, kinds)
    pieces = separate(
        cells, whole, settings.min_voxels, lambda part: name_object(part, ground, kinds)
    )
    return [(naming, rows[own]) for naming, own in pieces]


def _numbered(named: list[Named], num_cells: int, failures: Counter[str]) -> Recognition:
    named = sorted(named, key=lambda pair: (pair[0].centre[0], pair[0].centre[2]))
    label = np.full(num_cells, -1, dtype=np.int32)
    for number, (_, rows) in enumerate(named):
        label[rows] = number
    return Recognition(
        objects=tuple(n.found(number, len(rows)) for number, (n, rows) in enumerate(named)),
        label=label,
        failures=dict(failures),
    )
