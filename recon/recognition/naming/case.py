"""The cells of one object, and their properties that do not depend on the kind."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.recognition.cells import coarser, trust_by_points
from recon.recognition.fitting.composite import NOISE_FLOOR
from recon.recognition.fitting.least_squares import student_deviance
from recon.recognition.fitting.shapes import Candidate, candidates
from recon.recognition.naming.assembly import bic_of_pieces
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.limits import box_sizes
from recon.recognition.naming.visibility import NEAR_CELLS, coverage, filled_faces
from recon.recognition.segments.flat_pieces import FlatPieces, unsplit
from recon.recognition.segments.segmentation import split_colours
from recon.recognition.segments.solid_pieces import Pieces, solid_pieces
from recon.records import Box, FitFailure, Plane, Segments, Solid, Voxels

Array = NDArray[np.float64]

FORMLESS_NOISE = 0.5
"""Scale of the residuals, in cells, of a formless object."""
MEAN_DEVIANCE = 2.27
"""(nu + 1) E[log(1 + t^2 / nu)] of Student-t noise with nu = 3 degrees of freedom."""
MOST_CELLS, MOST_FOR_SOLIDS = 600, 300
"""Maximum number of cells for a composite fit and for a single solid: more do not change the
fits."""
INDEPENDENT_CELLS = 60.0
"""Errors of an object's cells are correlated: all of them weigh no more than this number of
independent cells. Chosen so that the probabilities are calibrated on simulated orbits."""
ON_SURFACE_CELLS = 0.75
"""Only a cell nearer than this shows a place on the face of a box: a table is open at its sides,
whose rims are near to its board and its legs."""
MOST_SOLIDS = 6
"""Maximum number of solids that an object is taken apart into."""
TRUSTS = 0.1, 4.0
"""Limits of the trust in a cell by its number of points."""
STRAY = 0.25
"""Trust below which a cell may be beside the object and does not count for its box: three of them
in a row make a lamp post as long as a bench."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """The cells of one object, and their properties that do not depend on the kind."""

    cells: Voxels
    """At most `MOST_CELLS` cells."""
    dense: Voxels
    """The same surface without gaps: as many larger cells."""
    ground: float
    """Height of the surface it stands on."""
    is_metric: bool
    """True if lengths are metres."""
    alone: tuple[Candidate, ...]
    """Single solids fitted to at most `MOST_FOR_SOLIDS` of the cells, best first."""

    @cached_property
    def weights(self) -> Array:
        """Weights (N,): cells with few points are more often off the surface than on it."""
        return trust_by_points(self.cells, TRUSTS)

    @cached_property
    def colours(self) -> Segments | FitFailure:
        """Two parts by colour, if there are two."""
        return split_colours(self.cells)

    @cached_property
    def box(self) -> dict[str, float]:
        """Sizes of the upright box around the cells that are no strays."""
        return box_sizes(self.cells.means[self.weights >= STRAY])

    @property
    def overall_slenderness(self) -> float:
        """Height over half the width of the box around the cells."""
        height = float(self.cells.means[:, 1].max()) - self.ground
        return height / max(self.box["radius"], 1e-9)

    @property
    def elongation(self) -> float:
        """Width over depth of the box around the cells."""
        return self.box["width"] / max(self.box["depth"], 1e-9)

    @cached_property
    def unsplit(self) -> FlatPieces:
        """The dense cells before planes are taken from them."""
        return unsplit(self.dense)

    @cached_property
    def faces(self) -> FlatPieces:
        """Planes of any tilt, and bars."""
        return self.unsplit.then("any")

    @cached_property
    def pieces(self) -> list[FlatPieces]:
        """Planes and bars of the cells, for every order of extraction.

        Under a board alone the rest are bars.
        """
        board = self.unsplit.then("board")
        walled = self.unsplit.then("upright").then("any")
        return [self.faces, board.then("upright"), walled, board]

    @cached_property
    def outer(self) -> FlatPieces:
        """Slopes that touch the cells from outside, and upright planes below them."""
        slopes = self.unsplit.then("outer")
        return replace(slopes.then("upright"), is_outer=True)

    def ways(self, kind: Kind) -> Sequence[Pieces]:
        """The splits of the cells that may show the parts of a kind."""
        if all("plane" in part.shapes for part in kind.parts):
            return [*self.pieces, self.outer]
        if any("plane" in part.shapes for part in kind.parts):
            return self.pieces
        shapes = {shape for part in kind.parts for shape in part.shapes}
        counts = {sum(part.count[end] for part in kind.parts) for end in (0, 1)}
        solids = [solid_pieces(self.dense, shapes, n) for n in sorted(counts) if n <= MOST_SOLIDS]
        return [*self.pieces, *solids]

    def dense_criterion(self, bic: float) -> float:
        """The same for a fit to the dense cells."""
        return bic / len(self.dense) - formless(self.dense)

    def criterion(self, bic: float) -> float:
        """BIC per cell, minus that of a formless object."""
        return bic / len(self.cells) - formless(self.cells)

    def lone_criterion(self, one: Candidate) -> float:
        """The same for a single solid."""
        return one.bic / min(len(self.cells), MOST_FOR_SOLIDS) - formless(self.cells)

    @cached_property
    def flat_criterion(self) -> float:
        """The lowest criterion of planes of no kind."""
        bics = [bic_of_pieces(self.dense, one.planes) for one in self.pieces if one.planes]
        return min(map(self.dense_criterion, bics), default=0.0)

    @cached_property
    def dense_lone_criterion(self) -> float:
        """The lowest criterion of the single solids on the dense cells."""
        floor = NOISE_FLOOR * self.dense.cell_size
        away = [one.solid.distances(self.dense.means) for one in self.alone]
        found = [self.dense_criterion(student_deviance(one, floor)) for one in away]
        return min(found, default=0.0)

    @cached_property
    def seen_criterion(self) -> float:
        """The same for the best single solid, times its visible share: a table is not a box."""
        best = self.alone[0] if self.alone else None
        if best is None or isinstance(best.solid, Plane):
            return 0.0 if best is None else self.lone_criterion(best)
        near_cells = ON_SURFACE_CELLS if isinstance(best.solid, Box) else NEAR_CELLS
        seen = float(coverage([best.solid], self.cells, near_cells)[0])
        return seen * self.lone_criterion(best)

    def filled(self, solid: Solid) -> float:
        """Share of the seen faces of a box that is closed; 1 of other solids."""
        if not isinstance(solid, Box):
            return 1.0
        return filled_faces(solid, self.cells, ON_SURFACE_CELLS)

    def evidence(self, criterion: float) -> float:
        """Log likelihood of a fit, limited to the number of independent cells."""
        return -0.5 * criterion * min(INDEPENDENT_CELLS, len(self.cells))


def a_case(voxels: Voxels, ground: float, is_metric: bool) -> Case:
    """The case of one object on the ground."""
    cells = _thinned(voxels, MOST_CELLS)
    few = _thinned(cells, MOST_FOR_SOLIDS)
    alone = candidates(few.means, trust_by_points(few, TRUSTS))
    return Case(
        cells=cells,
        dense=voxels if cells is voxels else coarser(voxels, MOST_CELLS)[0],
        ground=ground,
        is_metric=is_metric,
        alone=() if isinstance(alone, FitFailure) else alone,
    )


def formless(cells: Voxels) -> float:
    """Mean deviance per cell of a formless object."""
    return MEAN_DEVIANCE + 2.0 * float(np.log(FORMLESS_NOISE * cells.cell_size))


def _thinned(voxels: Voxels, most: int) -> Voxels:
    if len(voxels) <= most:
        return voxels
    rows = np.random.default_rng(0).choice(len(voxels), most, replace=False)
    return voxels.select(np.sort(rows))
