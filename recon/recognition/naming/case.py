"""The cells of one object, and what is known of them whatever the kind."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.shapes import Candidate, candidates
from recon.recognition.naming.visibility import coverage
from recon.recognition.segments.flat_pieces import FlatPiece, Step, flat_pieces
from recon.records import FitFailure, Plane, Voxels

Array = NDArray[np.float64]

FORMLESS_NOISE = 0.5
"""Scale of the residuals, in cells, that a thing of no form would leave."""
MEAN_DEVIANCE = 2.27
"""(nu + 1) E[log(1 + t^2 / nu)] of Student-t noise of nu = 3 degrees of freedom."""
MOST_CELLS, MOST_FOR_SOLIDS = 600, 300
"""Cells that a whole fit and one of a lone solid are made on: more do not change them."""
INDEPENDENT_CELLS = 60.0
"""Cells of an object err together: all of them weigh no more than so many that do not. Set where
probabilities come true over simulated orbits."""
WAYS: tuple[tuple[Step, ...], ...] = (("any",), ("board", "upright"), ("upright", "any"))
"""Orders in which planes are taken out of an object."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """The cells of one object, and what is known of them whatever the kind."""

    cells: Voxels
    """At most `MOST_CELLS` of them."""
    ground: float
    """Height of what it stands on."""
    is_metric: bool
    """True where lengths are metres."""
    alone: tuple[Candidate, ...]
    """Lone solids through at most `MOST_FOR_SOLIDS` of the cells, the best first."""

    @property
    def weights(self) -> Array:
        """(N,) cells of few points lie off the surface more often than on it."""
        return _weights(self.cells)

    @cached_property
    def pieces(self) -> list[list[FlatPiece]]:
        """Planes and bars of the cells, in every order in which planes are taken out."""
        return [flat_pieces(self.cells, way) for way in WAYS]

    @property
    def formless(self) -> float:
        """Deviance a cell that a thing of no form would leave on average."""
        return MEAN_DEVIANCE + 2.0 * float(np.log(FORMLESS_NOISE * self.cells.cell_size))

    def criterion(self, bic: float) -> float:
        """BIC a cell, less that of a thing of no form."""
        return bic / len(self.cells) - self.formless

    def lone_criterion(self, one: Candidate) -> float:
        """The same of a lone solid."""
        return one.bic / min(len(self.cells), MOST_FOR_SOLIDS) - self.formless

    @cached_property
    def seen_criterion(self) -> float:
        """That of the best lone solid as far as its surface is seen: a table is not a box."""
        best = self.alone[0] if self.alone else None
        if best is None or isinstance(best.solid, Plane):
            return 0.0 if best is None else self.lone_criterion(best)
        return float(coverage([best.solid], self.cells)[0]) * self.lone_criterion(best)

    def evidence(self, criterion: float) -> float:
        """Log likelihood of a fit, as far as its cells are independent."""
        return -0.5 * criterion * min(INDEPENDENT_CELLS, len(self.cells))


def a_case(voxels: Voxels, ground: float, is_metric: bool) -> Case:
    """The case of one object that stands on the ground."""
    cells = _thinned(voxels, MOST_CELLS)
    few = _thinned(cells, MOST_FOR_SOLIDS)
    alone = candidates(few.means, _weights(few))
    return Case(
        cells=cells,
        ground=ground,
        is_metric=is_metric,
        alone=() if isinstance(alone, FitFailure) else alone,
    )


def _thinned(voxels: Voxels, most: int) -> Voxels:
    if len(voxels) <= most:
        return voxels
    rows = np.random.default_rng(0).choice(len(voxels), most, replace=False)
    return voxels.select(np.sort(rows))


def _weights(cells: Voxels) -> Array:
    """Cells of few points lie off the surface more often than on it."""
    weights: Array = np.clip(cells.counts / np.median(cells.counts), 0.1, 4.0)
    return weights
