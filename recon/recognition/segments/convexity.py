"""Convex pieces: a concave crease separates two surfaces (Stein et al., LCCP, 2014)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.adjacency import near_pairs
from recon.recognition.cells import coarser, distinct, means
from recon.recognition.connectivity import in_order_of_appearance
from recon.recognition.fitting.normals import estimate_normals
from recon.recognition.unions import agreed_roots, numbered
from recon.records import Voxels

Array = NDArray[np.float64]
Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]
Numbers = NDArray[np.int64]

MOST_CELLS, COARSE_CELLS = 2000, 1500
"""Number of cells above which coarser cells show the creases as well, and their approximate
number."""
PATCH_CELLS = 3.0
"""Size of a patch: wide enough for a normal, narrower than an object."""
NUM_ROUNDS = 3
"""Rounds of moving the patches to the mean of their cells."""
LINK_CELLS = 2.5
"""Patches touch if they have cells within this distance, in cells."""
SMALLEST_TOUCH = 2
"""Minimum number of cell pairs between two touching patches."""
CONCAVE_DEG = 12.0
"""Angle up to which a crease is noise."""
CONVEX_SHARE = 0.3
"""Minimum share of the edges between two pieces that are convex: where a box stands close behind a
can, some of them are by chance."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Patches:
    """Small, nearly plane groups of cells."""

    label: Labels
    """(K,) patch of each cell."""
    middles: Array
    normals: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Relief:
    """The surface of one object as its creases need it, whatever the positions that saw it."""

    cells: Voxels
    """At most `MOST_CELLS` cells."""
    cell: NDArray[np.intp]
    """(N,) the one of them around each cell of the object."""

    @cached_property
    def normals(self) -> Array:
        """(K, 3) normals, away from the middle."""
        return estimate_normals(self.cells.means)

    @cached_property
    def touching(self) -> NDArray[np.intp]:
        """Pairs (2, E) of touching cells."""
        return near_pairs(self.cells.means, LINK_CELLS * self.cells.cell_size)

    @cached_property
    def rounded(self) -> Labels:
        """Convex piece (K,) of each cell, with outside away from the middle."""
        return _pieces(self, self.normals)


def relief_of(cells: Voxels) -> Relief:
    """The surface of the cells of one component."""
    if len(cells) > MOST_CELLS:
        coarse, _, cell = coarser(cells, COARSE_CELLS)
        return Relief(cells=coarse, cell=cell)
    return Relief(cells=cells, cell=np.arange(len(cells)))


def convex_pieces(relief: Relief, eyes: Array | None, smallest: int) -> Labels:
    """Convex piece (N,) of each cell of an object, numbered by descending size.

    Parameters
    ----------
    eyes : (3,) or (K, 3) float64, optional
        A position that sees the outer side of most of the surface, or one for each cell of the
        relief; if None, outside is away from the centre.
    smallest : int
        Pieces with fewer cells of the object join the nearest larger one.
    """
    few = smallest * len(relief.cells) // len(relief.cell)
    piece = relief.rounded if eyes is None else _pieces(relief, _outwards(relief, eyes))
    return _by_size(_absorbed(relief.cells, piece, few))[relief.cell]


def fewest_pieces(relief: Relief, views: Array | None, smallest: int) -> Labels:
    """Convex pieces (N,), with outside towards the middle of the views or the nearest of them.

    The middle of the views (V, 3) is behind some faces of an object seen from all around, and the
    nearest view on either side of a thin sheet. Either breaks single objects, so the one that gives
    fewer pieces is taken.
    """
    if views is None:
        return convex_pieces(relief, None, smallest)
    nearest = views[cKDTree(views).query(relief.cells.means)[1]]
    readings = [convex_pieces(relief, eyes, smallest) for eyes in (views.mean(axis=0), nearest)]
    return min(readings, key=np.max)


def _outwards(relief: Relief, eyes: Array) -> Array:
    """Normals (K, 3) towards the positions that saw the cells."""
    towards = np.einsum("ij,ij->i", relief.normals, eyes - relief.cells.means)
    oriented: Array = np.where(towards < 0, -1.0, 1.0)[:, None] * relief.normals
    return oriented


def _pieces(relief: Relief, normals: Array) -> Labels:
    """Convex piece (K,) of each cell, those of few cells included."""
    patches = _patches(relief.cells, normals)
    edges = _touching(relief.touching, patches)
    alike = np.einsum("ij,ij->i", *patches.normals[edges.T])
    edges = edges[np.argsort(-alike, kind="stable")]
    convex = _twice_held(edges, _is_convex(patches, edges), len(patches.middles))
    roots = agreed_roots(edges, convex, len(patches.middles), CONVEX_SHARE)
    piece: Labels = numbered(roots)[patches.label]
    return piece


def _patches(cells: Voxels, normals: Array) -> _Patches:
    reach = PATCH_CELLS * cells.cell_size
    # Positions in units of a patch, with normals: a patch ends where its surface bends.
    places = np.hstack([cells.means / reach, normals])
    seeds = np.floor(cells.means / reach).astype(np.int64)
    label = distinct(seeds)[1]
    for _ in range(NUM_ROUNDS):
        middles = means(places, label)
        label = in_order_of_appearance(nearest_middle(places, middles, label))
    middles = means(places, label)
    length = np.linalg.norm(middles[:, 3:], axis=1, keepdims=True)
    return _Patches(
        label=label.astype(np.int32),
        middles=middles[:, :3] * reach,
        normals=middles[:, 3:] / np.maximum(length, 1e-12),
    )


@njit(cache=True)
def nearest_middle(places: Array, middles: Array, label: Numbers) -> Numbers:
    """The nearest middle (N,) of each place, which is near that of its label.

    No middle is nearer to a place that is twice as far from the own one as this is from the place.
    """
    apart = np.empty((len(middles), len(middles)))
    for a in range(len(middles)):
        for b in range(len(middles)):
            apart[a, b] = _square(middles[a], middles[b])
    nearest = np.empty(len(places), dtype=np.int64)
    for i in range(len(places)):
        own = label[i]
        least = _square(places[i], middles[own])
        nearest[i], limit = own, 4.0 * least
        for other in range(len(middles)):
            is_near = apart[own, other] <= limit
            square = _square(places[i], middles[other]) if is_near else np.inf
            if square < least:
                nearest[i], least = other, square
    return nearest


@njit(cache=True)
def _square(first: Array, second: Array) -> float:
    total = 0.0
    for k in range(len(first)):
        total += (first[k] - second[k]) ** 2
    return total


def _touching(pairs: NDArray[np.intp], patches: _Patches) -> NDArray[np.intp]:
    """Pairs (E, 2) of patches that meet, the smaller number first, from those of cells."""
    first, second = patches.label[pairs].astype(np.int64)
    low, high = np.minimum(first, second), np.maximum(first, second)
    counts = np.bincount((low * len(patches.middles) + high)[low != high])
    edges = np.flatnonzero(counts >= SMALLEST_TOUCH)
    return np.column_stack(np.divmod(edges, len(patches.middles)))


def _is_convex(patches: _Patches, edges: NDArray[np.intp]) -> Mask:
    first, second = edges.T
    apart = patches.middles[first] - patches.middles[second]
    apart /= np.maximum(np.linalg.norm(apart, axis=1, keepdims=True), 1e-12)
    turn = np.einsum("ij,ij->i", patches.normals[first] - patches.normals[second], apart)
    alike = np.einsum("ij,ij->i", patches.normals[first], patches.normals[second])
    convex: Mask = (turn >= 0) | (alike > np.cos(np.radians(CONCAVE_DEG)))
    return convex


def _twice_held(edges: NDArray[np.intp], convex: Mask, count: int) -> Mask:
    """Convex edges whose patches share a third neighbour, so that one false edge joins nothing."""
    first, second = edges[convex].T
    touching = np.zeros((count, count), dtype=bool)
    touching[first, second] = touching[second, first] = True
    held = convex.copy()
    held[convex] = (touching[first] & touching[second]).any(axis=1)
    return held


def _absorbed(cells: Voxels, piece: Labels, smallest: int) -> Labels:
    """Merge each small piece into the large one next to it."""
    counts = np.bincount(piece)
    large = counts >= smallest
    if not large.any():
        return np.zeros(len(piece), dtype=np.int32)
    rows, kept = np.flatnonzero(~large[piece]), np.flatnonzero(large[piece])
    _, nearest = cKDTree(cells.means[kept]).query(cells.means[rows])
    absorbed = piece.copy()
    absorbed[rows] = piece[kept[nearest]]
    return absorbed


def _by_size(piece: Labels) -> Labels:
    counts = np.bincount(piece)
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order))
    ranked: Labels = rank[piece]
    return ranked
