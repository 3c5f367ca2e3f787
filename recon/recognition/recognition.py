"""From occupied cells to named objects (thesis 4.5)."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming.catalogue import read_catalogue
from recon.recognition.naming.naming import Naming, name_object
from recon.recognition.naming.thesis import name_by_quadrics
from recon.recognition.segments.components import connected, stacked
from recon.recognition.segments.ground import ground_height
from recon.recognition.segments.separation import Piece, Rows, reunite, separate
from recon.records import Recognition, Voxels
from recon.settings import RecognitionSettings

HOVERING = "hovers over the ground, held by nothing known"
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
    namer = _namer(voxels, settings)
    instance = components(voxels, settings)
    failures: Counter[str] = Counter()
    pieces: list[Piece] = []
    for number in range(int(instance.max(initial=-1)) + 1):
        rows = np.flatnonzero(instance == number)
        if len(rows) < settings.min_voxels:
            failures[f"fewer than {settings.min_voxels} cells"] += 1
        else:
            pieces.append((namer(rows), rows))
    if settings.recogniser == "robust":
        pieces = reunite(pieces, namer)
        pieces = [part for piece in pieces for part in separate(piece, voxels, settings, namer)]
    held = [piece for piece in pieces if not piece[0].is_hovering]
    failures[HOVERING] += len(pieces) - len(held)
    for naming, _ in held:
        failures.update(naming.failures)
    return _numbered(held, len(voxels), +failures)


def _namer(voxels: Voxels, settings: RecognitionSettings) -> Callable[[Rows], Naming]:
    """What names the object that rows of the map are."""
    kinds = read_catalogue(None if settings.catalogue is None else Path(settings.catalogue))
    ground = ground_height(voxels, settings)
    if settings.recogniser == "thesis":
        tolerance_deg = settings.hue_tolerance_deg
        return lambda rows: name_by_quadrics(voxels.select(rows), ground, kinds, tolerance_deg)
    return lambda rows: name_object(voxels.select(rows), ground, kinds)


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


def _numbered(pieces: list[Piece], num_cells: int, failures: Counter[str]) -> Recognition:
    pieces = sorted(pieces, key=lambda pair: (pair[0].centre[0], pair[0].centre[2]))
    label = np.full(num_cells, -1, dtype=np.int32)
    for number, (_, rows) in enumerate(pieces):
        label[rows] = number
    return Recognition(
        objects=tuple(n.found(number, len(rows)) for number, (n, rows) in enumerate(pieces)),
        label=label,
        failures=dict(failures),
    )
