"""Cuts of an object into two with little contact: at its waist, and between its main solids."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.adjacency import neighbours
from recon.recognition.connectivity import linked
from recon.recognition.fitting.ransac import find_solids, same_solid
from recon.recognition.segments.convexity import Relief
from recon.records import Solid, Voxels

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Cut = tuple[Mask, float]
"""Which cells are on its second side, and how much the two touch."""

MOST_DRAWN = 600
"""Approximate maximum number of cells among which cuts are searched."""
SAME_CUT = 0.99
"""Minimum share of the cells on the same side of two cuts that count as one."""
TOUCHING = 1.5
"""Cells of one side of a cut that are closer than this, in cells, are in one piece."""
MOST_ROUNDS = 20


def narrow_cuts(cells: Voxels, relief: Relief, min_voxels: int, most_touch: float) -> list[Cut]:
    """Splits of the cells with little contact.

    They are searched among coarser cells where there are many.

    Parameters
    ----------
    relief : Relief
        The surface of the cells.
    min_voxels : int
        Minimum cells of either side.
    most_touch : float
        Maximum number of touching cells over the root of the smaller side's cells.
    """
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
    return [(cut, touch) for cut, touch in zip(whole, touches, strict=True) if touch < most_touch]


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
