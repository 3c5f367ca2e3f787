"""Recognition: from occupied cells to named objects (thesis 4.5)."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, transform
from recon.notices import notify
from recon.recognition.connectivity import grouped
from recon.recognition.description import described
from recon.recognition.frames import moved_object
from recon.recognition.layout import Layout, lay_out
from recon.recognition.naming.catalogue import read_catalogues
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.naming import Naming
from recon.recognition.naming.recognisers import RECOGNISERS
from recon.recognition.reunion import reunite
from recon.recognition.segments.convexity import convex_pieces, relief_of
from recon.recognition.segments.focus import Focus, find_focus
from recon.recognition.separation import (
    Namer,
    Piece,
    Reliefs,
    Rows,
    cut_at_creases,
    separate,
)
from recon.records import FoundObject, Recognition, Voxels
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
T = TypeVar("T")

HOVERING = "hovers over the ground, held by nothing known"
SEEN_ONCE = "seen once: it moves, or is false"
VIEWS_TO_TELL = 3
"""Views of the most seen cell from which a component seen by no two views has moved."""


def recognise(
    voxels: Voxels, settings: RecognitionSettings, T_world_left: Array | None = None
) -> Recognition:
    """Find, describe and name the objects of a map.

    Parameters
    ----------
    voxels : Voxels
        Occupied cells, world, y up.
    T_world_left : (V, 4, 4) float64, optional
        Poses of the views of the map.

    Returns
    -------
    Recognition
        Objects numbered by position (x, then z), a label per input cell, the ground, support and
        wall planes, and failures counted by reason.

    Raises
    ------
    InputError
        If a catalogue cannot be read.
    """
    kinds = read_catalogues(settings.catalogue)
    _warn_of_scale(kinds, settings)
    focus = None if T_world_left is None else find_focus(T_world_left)
    layout = lay_out(voxels, settings, focus)
    namer, reliefs = _namer(layout, settings, kinds), _reliefs(layout)
    failures: Counter[str] = Counter()
    pieces = [(namer(rows), rows) for rows in _clumps(layout, settings, failures)]
    if settings.recogniser != "thesis":
        if kinds:
            pieces = reunite(pieces, layout.cells, namer)
        if kinds and not (settings.ground is None and _is_one(focus)):
            apart = partial(separate, settings=settings, relief_of=reliefs, name=namer)
            pieces = [p for piece in pieces for p in apart(piece, layout.cells)]
            # A crown that touched another object is now free to join its trunk.
            pieces = reunite(pieces, layout.cells, namer)
        if layout.has_floor and not _is_one(focus):
            eyes = None if T_world_left is None else _level_positions(T_world_left, layout)
            cut = partial(cut_at_creases, relief_of=reliefs, eyes=eyes, name=namer)
            pieces = [p for piece in pieces for p in cut(piece, layout.cells, settings.min_voxels)]
    held = [piece for piece in pieces if not piece[0].is_hovering]
    failures[HOVERING] += len(pieces) - len(held)
    for naming, _ in held:
        failures.update(naming.failures)
    return _numbered(held, layout, reliefs, settings, +failures)


def components(voxels: Voxels, settings: RecognitionSettings) -> NDArray[np.int32]:
    """Component label of each cell after removal of the planes.

    Returns
    -------
    component : (K,) int32
        0, 1, ...; -1 = on a plane. Components too small to be named are included.
    """
    return lay_out(voxels, settings).component


def _warn_of_scale(kinds: tuple[Kind, ...], settings: RecognitionSettings) -> None:
    names = [kind.name for kind in kinds if kind.needs_scale]
    if names and settings.unit is None:
        notify(
            "names-need-scale",
            f"{', '.join(names)} have sizes in metres, but the scale is not known: their sizes "
            "are ignored",
        )


def _namer(layout: Layout, settings: RecognitionSettings, kinds: tuple[Kind, ...]) -> Namer:
    """The function that names the object in some rows of the map."""
    recogniser = RECOGNISERS.load(settings.recogniser)

    def name(rows: Rows) -> Naming:
        cells = layout.cells.select(rows)
        return recogniser(cells, layout.height_under(cells), kinds, settings)

    return _once(name)


def _reliefs(layout: Layout) -> Reliefs:
    """The function that gives the surface of the object in some rows."""
    return _once(lambda rows: relief_of(layout.cells.select(rows)))


def _once(work: Callable[[Rows], T]) -> Callable[[Rows], T]:
    """The same function, which does its work once for the same rows."""
    known: dict[bytes, T] = {}

    def result(rows: Rows) -> T:
        key = rows.tobytes()
        if key not in known:
            known[key] = work(rows)
        return known[key]

    return result


def _clumps(layout: Layout, settings: RecognitionSettings, failures: Counter[str]) -> list[Rows]:
    """Components that may be objects; the others are counted as failures."""
    found = []
    views = layout.cells.num_views
    for rows in grouped(layout.component, layout.num_components):
        if len(rows) < settings.min_voxels:
            failures[f"fewer than {settings.min_voxels} cells"] += 1
        elif views is not None and views.max() >= VIEWS_TO_TELL and np.median(views[rows]) <= 1:
            failures[SEEN_ONCE] += 1
        else:
            found.append(rows)
    return found


def _is_one(focus: Focus | None) -> bool:
    """True if all views look at one object."""
    return focus is not None


def _level_positions(T_world_left: Array, layout: Layout) -> Array:
    """Positions (V, 3) of the views in the level frame."""
    return transform(invert(layout.T_world_level), T_world_left[:, :3, 3])


def _numbered(
    pieces: list[Piece],
    layout: Layout,
    reliefs: Reliefs,
    settings: RecognitionSettings,
    failures: Counter[str],
) -> Recognition:
    """The objects in order of position, in the world frame."""
    placed = [(_in_world(*piece, layout, reliefs, settings), piece[1]) for piece in pieces]
    placed.sort(key=lambda pair: (pair[0].centre[0], pair[0].centre[2]))
    label = np.full(len(layout.cells), -1, dtype=np.int32)
    for number, (_, rows) in enumerate(placed):
        label[rows] = number
    return Recognition(
        objects=tuple(replace(found, id=number) for number, (found, _) in enumerate(placed)),
        label=label,
        failures=dict(failures),
        planes=layout.planes,
    )


def _in_world(
    naming: Naming, rows: Rows, layout: Layout, reliefs: Reliefs, settings: RecognitionSettings
) -> FoundObject:
    cells = layout.cells.select(rows)
    found = described(naming.found(0, len(rows)), naming.solid, cells, settings.unit)
    pieces = 1 + int(convex_pieces(reliefs(rows), None, settings.min_voxels).max())
    return moved_object(
        replace(found, support=layout.support(cells), pieces=pieces), layout.T_world_level
    )
