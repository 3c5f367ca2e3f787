"""Objects in one component of the map."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.connectivity import overhanging
from recon.recognition.cuts import narrow_cuts
from recon.recognition.fitting.shapes import fit
from recon.recognition.naming.naming import Naming
from recon.recognition.segments.convexity import Relief, fewest_pieces
from recon.records import (
    UNKNOWN,
    Cone,
    Ellipsoid,
    FitFailure,
    Sphere,
    TruncatedCone,
    Voxels,
)
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Piece = tuple[Naming, Rows]
Part = tuple[Rows, float]
"""Cells, and their share on the single solid that fits them best."""
Namer = Callable[[Rows], Naming]
"""Names the object in some rows of the map."""
Reliefs = Callable[[Rows], Relief]
"""The surface of the object in some rows of the map."""

EXPLAINED, CLOSELY_EXPLAINED = 1.0, 2.0
"""Deviance per cell below that of a formless object from which one object is enough, unless it is
long; and from which it is in any case: two objects are not on one solid to a fifth of a cell."""
STRAYS, STRAY_CELLS = 0.1, 1.5
"""Share of an object's cells that are farther than so many cells from its solids, above which there
may be another object."""
LONG = 2.0
"""Length over width of a footprint, in standard deviations, above which it may be two objects."""
SHEET = 1.0
"""Standard deviation across a footprint, in cells, below which it is a sheet, such as a wall or a
fence: every cut through a sheet touches little, so that no cut is a waist."""
WAIST, WIDE_WAIST = 1.6, 2.4
"""Maximum number of touching cells over the root of a side's cells, without and with a name: 2.5
for a closed shell cut in half."""
SMALLEST_PIECE = 0.03
"""Minimum share of an object's cells in a piece of it."""
PIECES_SHARE, EXPLAINED_SHARE = 0.8, 0.7
"""Minimum share of an object's cells in pieces that are solids, and of a piece's cells on its
solid."""
ON_SOLID_CELLS = 0.75
"""A cell within this share of the cell size is on a solid."""
BETTER = 0.1
"""Share of the cells that pieces must explain beyond one solid: a round side is not a row of
walls."""
MOST_FITTED = 300
"""Approximate maximum number of cells that a solid is fitted to."""
APART = 0.5
"""Minimum decrease of the deviance per cell for two objects instead of one."""
TIPS = (Cone, TruncatedCone, Sphere, Ellipsoid)
"""Solids that nothing stands on."""
MOST_OBJECTS = 8
"""Maximum objects of one component, which limits the work for a street or a wall."""


def separate(
    whole: Piece,
    voxels: Voxels,
    settings: RecognitionSettings,
    *,
    relief_of: Reliefs,
    name: Namer,
) -> list[Piece]:
    """The objects in a piece of the map: itself, or several if they fit better."""
    waiting: list[Piece] = [whole]
    done: list[Piece] = []
    while waiting:
        piece = waiting.pop()
        room = len(waiting) + len(done) + 2 <= MOST_OBJECTS
        halves = _halves(piece, voxels, settings.min_voxels, relief_of, name) if room else []
        waiting.extend(halves)
        if not halves:
            done.append(piece)
    return done


def cut_at_creases(
    whole: Piece,
    voxels: Voxels,
    min_voxels: int,
    *,
    relief_of: Reliefs,
    eyes: Array | None,
    name: Namer,
) -> list[Piece]:
    """Split an unnamed object into its convex pieces, if solids explain these.

    Convexity alone splits single objects, so the split is accepted only if most cells are in pieces
    that each fit a solid, and these explain more than one solid does.

    Parameters
    ----------
    eyes : (V, 3) float64, optional
        Positions of the views.
    """
    naming, rows = whole
    if naming.label != UNKNOWN or len(rows) < 2 * min_voxels:
        return [whole]
    parts = _solid_parts(rows, voxels, min_voxels, relief_of, eyes)
    if not parts or not _explains_more(parts, _explained(voxels.select(rows))):
        return [whole]
    pieces = [(_held_by(name(part), naming), part) for part, _ in parts]
    return [whole] if _is_topped(pieces, voxels) else pieces


def _solid_parts(
    rows: Rows, voxels: Voxels, min_voxels: int, relief_of: Reliefs, eyes: Array | None
) -> list[Part]:
    """The convex pieces of an object; none if too many of its cells are in pieces without a solid.

    A piece that is not a solid is split again, in its own finer cells, before the whole is judged.
    """
    cells = voxels.select(rows)
    piece = fewest_pieces(relief_of(rows), eyes, max(min_voxels, int(SMALLEST_PIECE * len(rows))))
    piece = overhanging(cells.means, piece)
    if not piece.any():
        return []
    parts: list[Part] = []
    spare = (1.0 - PIECES_SHARE) * len(rows)
    for number in np.argsort(-np.bincount(piece), kind="stable"):
        own = rows[piece == number]
        share = _explained(voxels.select(own))
        is_whole = share > EXPLAINED_SHARE or len(own) < 2 * min_voxels
        finer = [] if is_whole else _solid_parts(own, voxels, min_voxels, relief_of, eyes)
        is_split = bool(finer) and _explains_more(finer, share)
        parts += finer if is_split else [(own, share)]
        spare -= 0 if is_split or share > EXPLAINED_SHARE else len(own)
        if spare < 0.0:
            return []
    return parts


def _explains_more(parts: list[Part], share: float) -> bool:
    """True if the solids of pieces explain more of their cells than one solid does, a share."""
    return _by_solids(parts) > (share + BETTER) * sum(len(rows) for rows, _ in parts)


def _held_by(piece: Naming, whole: Naming) -> Naming:
    """A piece that hovers only if the whole does: what is stacked is held by the rest."""
    return replace(piece, is_hovering=piece.is_hovering and whole.is_hovering)


def _by_solids(parts: list[Part]) -> float:
    """Number of cells on the solids of the pieces; 0 if too many are in pieces without one."""
    in_solids = sum(len(rows) for rows, share in parts if share > EXPLAINED_SHARE)
    if in_solids < PIECES_SHARE * sum(len(rows) for rows, _ in parts):
        return 0.0
    return sum(share * len(rows) for rows, share in parts)


def _explained(cells: Voxels) -> float:
    """Share of the cells on the single solid that fits them best."""
    step = max(1, len(cells) // MOST_FITTED)
    solid = fit(cells.means[::step])
    if isinstance(solid, FitFailure):
        return 0.0
    on_it = solid.distances(cells.means) < ON_SOLID_CELLS * cells.cell_size
    return float(on_it.mean())


def _halves(
    whole: Piece, voxels: Voxels, min_voxels: int, relief_of: Reliefs, name: Namer
) -> list[Piece]:
    """Two objects that explain the cells better than one; empty if there are none."""
    naming, rows = whole
    cells = voxels.select(rows)
    across, along = _spread(cells.means[:, ::2])
    has_strays = stray_share(naming, cells) > STRAYS
    enough = EXPLAINED if along < LONG * across else CLOSELY_EXPLAINED
    if naming.deviance < -enough * len(rows) and not has_strays:
        return []
    waist = 0.0 if across < SHEET * voxels.cell_size else WAIST
    best: list[Piece] = []
    least = naming.deviance - APART * len(rows)
    num_names = 0 if naming.label == UNKNOWN else 1 if has_strays else 2
    # Two names are better than one only if both are surer.
    least_sure = (naming.probability or 0.0) if num_names == 2 else 0.0
    for second, touch in narrow_cuts(cells, relief_of(rows), min_voxels, WIDE_WAIST):
        sides = (rows[~second], rows[second])
        halves = _objects(sides, 2 if touch >= waist else num_names, name)
        deviance = sum(half.deviance for half, _ in halves)
        is_sure = all((half.probability or 0.0) >= least_sure for half, _ in halves)
        if halves and is_sure and deviance < least and not _is_topped(halves, voxels):
            best, least = halves, deviance
    return best


def stray_share(naming: Naming, cells: Voxels) -> float:
    """Share of the cells that are far from the solids of a naming; 0 without solids."""
    if not naming.parts:
        return 0.0
    away = np.min([part.solid.distances(cells.means) for part in naming.parts], axis=0)
    return float((away > STRAY_CELLS * cells.cell_size).mean())


def _objects(sides: tuple[Rows, Rows], num_names: int, name: Namer) -> list[Piece]:
    """The objects on both sides of a cut; empty as soon as one side is not an object.

    Parameters
    ----------
    num_names : int
        Number of sides that must have a name; others need a solid.
    """
    halves: list[Piece] = []
    spare = len(sides) - num_names
    for rows in sides:
        half = name(rows)
        if half.label == UNKNOWN:
            spare -= 1
            if spare < 0 or not half.parts:
                return []
        halves.append((half, rows))
    return halves


def _is_topped(pieces: list[Piece], voxels: Voxels) -> bool:
    """True if a piece stands on the crown or the roof of a named one: it is a part of that.

    Nothing stands on a tip: the lower half of an hourglass is not a cottage.
    """
    tips = [
        voxels.means[rows]
        for naming, rows in pieces
        if naming.label != UNKNOWN and naming.parts and isinstance(naming.parts[-1].solid, TIPS)
    ]
    others = [voxels.means[rows] for _, rows in pieces]
    return any(_stands_on(other, tip) for tip in tips for other in others)


def _stands_on(other: Array, tip: Array) -> bool:
    """True if cells (N, 3) are all in the upper half of others, or above, and in their middle."""
    low, high = np.quantile(tip[:, ::2], [0.25, 0.75], axis=0)
    middle = other[:, ::2].mean(axis=0)
    is_above = other[:, 1].min() > np.median(tip[:, 1])
    return bool(is_above and (low <= middle).all() and (middle <= high).all())


def _spread(floor: Array) -> tuple[float, float]:
    """Standard deviations of a footprint (N, 2) across and along."""
    across, along = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(floor.T)), 1e-12))
    return float(across), float(along)
