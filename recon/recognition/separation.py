"""Objects in one component of the map."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.adjacency import neighbours
from recon.recognition.connectivity import linked, overhanging
from recon.recognition.fitting.ransac import find_solids, same_solid
from recon.recognition.fitting.shapes import fit
from recon.recognition.naming.naming import Naming
from recon.recognition.segments.convexity import Relief, fewest_pieces
from recon.records import UNKNOWN, FitFailure, Solid, Voxels
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]
Piece = tuple[Naming, Rows]
Cut = tuple[Mask, float]
"""Which cells are on its second side, and how much the two touch."""
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
MOST_DRAWN = 600
"""Approximate maximum number of cells among which cuts are searched."""
SAME_CUT = 0.99
"""Minimum share of the cells on the same side of two cuts that count as one."""
TOUCHING = 1.5
"""Cells of one side of a cut that are closer than this, in cells, are in one piece."""
MOST_ROUNDS = 20
APART = 0.5
"""Minimum decrease of the deviance per cell for two objects instead of one."""
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
        cuts = partial(_cuts, relief_of=relief_of, min_voxels=settings.min_voxels)
        halves = _halves(piece, voxels, cuts, name) if room else []
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
    cells = voxels.select(rows)
    smallest = max(min_voxels, int(SMALLEST_PIECE * len(rows)))
    piece = fewest_pieces(relief_of(rows), eyes, smallest)
    piece = overhanging(cells.means, piece)
    parts = [np.flatnonzero(piece == number) for number in range(int(piece.max()) + 1)]
    explained = _by_solids(cells, parts) if len(parts) > 1 else 0.0
    if not explained or explained < (_explained(cells) + BETTER) * len(rows):
        return [whole]
    return [(name(rows[part]), rows[part]) for part in parts]


def _by_solids(cells: Voxels, parts: list[Rows]) -> float:
    """Number of cells on the solids of the pieces; 0 if too many are in pieces without one."""
    explained, spare = 0.0, (1.0 - PIECES_SHARE) * len(cells)
    for part in sorted(parts, key=len, reverse=True):
        share = _explained(cells.select(part))
        explained += share * len(part)
        spare -= 0.0 if share > EXPLAINED_SHARE else len(part)
        if spare < 0.0:
            return 0.0
    return explained


def _explained(cells: Voxels) -> float:
    """Share of the cells on the single solid that fits them best."""
    step = max(1, len(cells) // MOST_FITTED)
    solid = fit(cells.means[::step])
    if isinstance(solid, FitFailure):
        return 0.0
    on_it = solid.distances(cells.means) < ON_SOLID_CELLS * cells.cell_size
    return float(on_it.mean())


def _halves(
    whole: Piece, voxels: Voxels, cuts: Callable[[Voxels, Rows], list[Cut]], name: Namer
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
    for second, touch in cuts(cells, rows):
        sides = (rows[~second], rows[second])
        halves = _objects(sides, 2 if touch >= waist else num_names, name)
        deviance = sum(half.deviance for half, _ in halves)
        if halves and deviance < least:
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


def _spread(floor: Array) -> tuple[float, float]:
    """Standard deviations of a footprint (N, 2) across and along."""
    across, along = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(floor.T)), 1e-12))
    return float(across), float(along)


def _cuts(cells: Voxels, rows: Rows, *, relief_of: Reliefs, min_voxels: int) -> list[Cut]:
    """Splits of the cells with little contact: at the waist, and between the main solids.

    They are searched among coarser cells where there are many.
    """
    relief = relief_of(rows)
    coarse = relief.cells
    floor = coarse.means[:, ::2]
    cuts = [_two_means(floor, axis) for axis in np.linalg.eigh(np.cov(floor.T))[1].T[::-1]]
    found = _main_solids(coarse.means, min_voxels)
    if len(found) == 2:
        first, second = (solid.distances(coarse.means) for solid in found)
        cuts.append(_gathered(second < first, coarse))
    fine = [cut[relief.cell] for cut in _distinct(cuts)]
    whole = [cut for cut in fine if min(cut.sum(), (~cut).sum()) >= min_voxels]
    pairs = neighbours(cells.index)
    touches = [_touch(cut, pairs) for cut in whole]
    return [(cut, touch) for cut, touch in zip(whole, touches, strict=True) if touch < WIDE_WAIST]


def _gathered(second: Mask, cells: Voxels) -> Mask:
    """A cut whose islands, apart from the rest of their side, join the side they are nearer to.

    A solid goes on behind the other object: cells beyond it, such as a trunk, are not its own.
    """
    mains = []
    for side in (~second, second):
        rows = np.flatnonzero(side)
        if not len(rows):
            return second
        label = linked(cells.means[rows], TOUCHING * cells.cell_size)
        mains.append(rows[label == np.argmax(np.bincount(label))])
    islands = np.setdiff1d(np.arange(len(cells)), np.concatenate(mains), assume_unique=True)
    away = [cKDTree(cells.means[own]).query(cells.means[islands])[0] for own in mains]
    gathered = second.copy()
    gathered[islands] = away[1] < away[0]
    return gathered


def _main_solids(points: Array, min_points: int) -> list[Solid]:
    """At most two solids with the most points on them."""
    rng = np.random.default_rng(0)
    if len(points) > MOST_DRAWN:
        points = points[np.sort(rng.choice(len(points), MOST_DRAWN, replace=False))]
    found = find_solids(points, min_points, rng, most=2, refit=same_solid)
    return [one.solid for one in found]


def _distinct(cuts: list[Mask]) -> list[Mask]:
    """Cuts that differ in more than a few cells, whichever side is the second."""
    kept: list[Mask] = []
    for cut in cuts:
        alike = [float((cut == other).mean()) for other in kept]
        if all(1.0 - SAME_CUT < share < SAME_CUT for share in alike):
            kept.append(cut)
    return kept


def _touch(second: Mask, pairs: NDArray[np.intp]) -> float:
    """Touching cells of the two sides over the root of the smaller side's cells.

    Parameters
    ----------
    pairs : (E, 2)
        Rows of neighbouring cells.
    """
    is_touching = np.zeros(len(second), dtype=bool)
    is_touching[pairs[second[pairs[:, 0]] != second[pairs[:, 1]]]] = True
    smaller = min(second.sum(), (~second).sum())
    return float(is_touching.sum() / 2.0 / np.sqrt(smaller))


def _two_means(floor: Array, axis: Array) -> Mask:
    """Two clusters, started at the two ends of an axis."""
    some = floor[:: -(-len(floor) // MOST_DRAWN)]
    along = some @ axis
    low, high = np.quantile(along, [0.1, 0.9])
    centres = np.stack([some[rows].mean(axis=0) for rows in (along <= low, along >= high)])
    second = np.zeros(len(some), dtype=bool)
    for _ in range(MOST_ROUNDS):
        before, second = second, _is_nearer_second(some, centres)
        if (second == before).all() or second.all() or not second.any():
            break
        centres = np.stack([some[~second].mean(axis=0), some[second].mean(axis=0)])
    return _is_nearer_second(floor, centres)


def _is_nearer_second(floor: Array, centres: Array) -> Mask:
    """Mask (N,) of the positions nearer to the second of two centres."""
    away = np.linalg.norm(floor[:, None] - centres, axis=2)
    nearer: Mask = away[:, 1] < away[:, 0]
    return nearer
