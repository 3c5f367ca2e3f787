"""Objects taken apart into solids: each cell belongs to the solid that it is nearest to."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import NOISE_FLOOR
from recon.recognition.fitting.least_squares import student_deviance
from recon.recognition.fitting.shapes import AS_GOOD, SAMPLE, Candidate, candidates, from_points
from recon.recognition.segments.flat_pieces import LEAST_PLANE, FlatPiece, FlatPieces, piece_of
from recon.records import FitFailure, Solid, Voxels

Array = NDArray[np.float64]
Labels = NDArray[np.intp]

MOST_CELLS = 250
"""Approximate maximum number of cells among which the solids are searched."""
SPLITS = (0.5, 0.35, 0.65)
"""Shares of the cells in the first of two solids at the start."""
FEW_ROUNDS, MOST_ROUNDS = 2, 8
"""Rounds of assignment that choose the most promising start, and that follow it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SolidPieces:
    """An object taken apart into as many solids as a kind has parts."""

    cells: Voxels
    """Of the object."""
    pieces: tuple[FlatPiece, ...]
    is_outer: bool = False

    def of(self, shapes: Collection[str]) -> Sequence[FlatPiece]:
        """The pieces that have one of some shapes."""
        return [one for one in self.pieces if _shape(one.solid) in shapes]


Pieces = FlatPieces | SolidPieces


def solid_pieces(cells: Voxels, shapes: Collection[str], count: int) -> SolidPieces:
    """The solids of some shapes that explain the cells best, each with the cells nearest to it.

    Cells and solids are assigned to each other in turn, from cuts along the height and along the
    footprint.

    Parameters
    ----------
    shapes : collection of str
        Shapes of the solids, as `from_points` has them.
    count : int
        Number of solids, at least 1.
    """
    points = cells.means[:: -(-len(cells) // MOST_CELLS)]
    found = [_settled(points, one, shapes, FEW_ROUNDS) for one in _starts(points, count)]
    whole = [solids for solids in found if solids]
    if not whole:
        return SolidPieces(cells=cells, pieces=())
    floor = NOISE_FLOOR * cells.cell_size
    best = min(whole, key=lambda solids: student_deviance(_away(points, solids).min(axis=0), floor))
    label = _away(points, best).argmin(axis=0)
    best = _settled(points, label, shapes, MOST_ROUNDS) or best
    nearest = _away(cells.means, best).argmin(axis=0)
    rows = [np.flatnonzero(nearest == number) for number in range(len(best))]
    return SolidPieces(
        cells=cells,
        pieces=tuple(
            piece_of(cells, own, solid)
            for own, solid in zip(rows, best, strict=True)
            if _is_nearly_best(solid, cells.means[own])
        ),
    )


def _starts(points: Array, count: int) -> Iterator[Labels]:
    """Labels (N,) of points in slices along the height and along their footprint."""
    footprint = points[:, ::2] - points[:, ::2].mean(axis=0)
    along = footprint @ np.linalg.eigh(footprint.T @ footprint)[1][:, 1]
    for values in (points[:, 1], along):
        rank = np.argsort(np.argsort(values, kind="stable")) / len(values)
        for share in SPLITS if count == 2 else SPLITS[:1]:
            # Of two slices the first has this share; more are equal.
            yield np.digitize(rank, [share] if count == 2 else np.arange(1, count) / count)


def _settled(points: Array, label: Labels, shapes: Collection[str], rounds: int) -> list[Solid]:
    """The solids that some slices lead to; none if one of them vanishes."""
    solids: list[Solid] = []
    for _ in range(rounds):
        fits = [_fitted(points[label == number], shapes) for number in range(int(label.max()) + 1)]
        whole = [one.solid for one in fits if one is not None]
        if len(whole) < len(fits):
            return []
        before, label, solids = label, _away(points, whole).argmin(axis=0), whole
        if (label == before).all() or label.max() < before.max():
            break
    return solids


def _fitted(points: Array, shapes: Collection[str]) -> Candidate | None:
    """The best fit of some shapes; None if there is none."""
    if len(points) < LEAST_PLANE:
        return None
    fits = [from_points(shape, points) for shape in sorted(shapes)]
    found = [one for one in fits if not isinstance(one, FitFailure)]
    return min(found, key=lambda one: one.bic, default=None)


def _is_nearly_best(solid: Solid, points: Array) -> bool:
    """True if no solid of another shape fits points clearly better."""
    ranked = candidates(points)
    if isinstance(ranked, FitFailure):
        return False
    own = [one.bic for one in ranked if _shape(one.solid) == _shape(solid)]
    lowest = min(one.bic for one in ranked)
    return bool(own) and own[0] <= lowest + AS_GOOD * min(len(points), SAMPLE)


def _away(points: Array, solids: Sequence[Solid]) -> Array:
    """Distances (S, N) of points to solids."""
    return np.stack([solid.distances(points) for solid in solids])


def _shape(solid: Solid) -> str:
    """The shape of a solid as catalogues have it."""
    return solid.kind.removeprefix("truncated ")
