"""What cells may be: each kind of the catalogue, a thing of no kind, or nothing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Stack, fit_stack, solids
from recon.recognition.fitting.shapes import SAMPLE, candidates
from recon.recognition.naming.catalogue import Kind
from recon.recognition.naming.colour_consistency import colour_opinions
from recon.recognition.naming.visibility import is_hovering, unseen_parts
from recon.records import FitFailure, Solid, Voxels

Array = NDArray[np.float64]

FORMLESS_NOISE = 0.5
"""Scale of the residuals, in cells, that a thing of no form would leave."""
MEAN_DEVIANCE = 2.27
"""(nu + 1) E[log(1 + t^2 / nu)] of Student-t noise of nu = 3 degrees of freedom."""
MOST_CELLS = 2000
"""Cells a fit is made on: more do not change it."""
INDEPENDENT_CELLS = 60.0
"""Cells of an object err together: all of them weigh no more than so many that do not. Set where
probabilities come true over simulated orbits."""
RATIO_SPREAD = 0.05
"""Standard deviation of a ratio of sizes, over which the bounds of the catalogue blur."""
LOG_NO_KIND = -4.0
"""Log of how much rarer a stack of no kind is than one of the catalogue."""
LARGEST_TO_EXTENT = 2.0
"""A fit larger than so many times the extent of its cells is none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explanation:
    """One thing that cells may be, and how likely it is."""

    kind: Kind | None
    """None: of no kind."""
    evidence: float
    """Log of its likelihood, up to a constant of the object."""
    criterion: float
    """BIC a cell, less that of a thing of no form: the lower, the better the cells are known."""
    stack: Stack | None = None
    """The whole fit; None for a single solid and for nothing."""
    solids: tuple[Solid, ...] = ()
    """From the ground up."""


def explain(voxels: Voxels, ground: float, kinds: tuple[Kind, ...]) -> list[Explanation]:
    """All explanations of the cells of one object that stands on the ground; at least one."""
    cells = _thinned(voxels)
    of_no_kind = [
        Explanation(kind=None, evidence=_evidence(0.0, len(cells)), criterion=0.0),
        *_alone(cells, ground),
    ]
    return [*_whole(cells, ground, kinds), *of_no_kind]


def _thinned(voxels: Voxels) -> Voxels:
    if len(voxels) <= MOST_CELLS:
        return voxels
    rows = np.random.default_rng(0).choice(len(voxels), MOST_CELLS, replace=False)
    return voxels.select(np.sort(rows))


def _evidence(criterion: float, num_cells: int) -> float:
    return -0.5 * criterion * min(INDEPENDENT_CELLS, num_cells)


def _formless(cells: Voxels) -> float:
    """Deviance a cell that a thing of no form would leave on average."""
    return MEAN_DEVIANCE + 2.0 * float(np.log(FORMLESS_NOISE * cells.cell_size))


def _weights(cells: Voxels) -> Array:
    """Cells of few points lie off the surface more often than on it."""
    weights: Array = np.clip(cells.counts / np.median(cells.counts), 0.1, 4.0)
    return weights


def _alone(cells: Voxels, ground: float) -> list[Explanation]:
    """One solid, if the cells reach down to the ground."""
    ranked = candidates(cells.means, _weights(cells))
    if is_hovering(cells, ground) or isinstance(ranked, FitFailure):
        return []
    criterion = ranked[0].bic / min(len(cells), SAMPLE) - _formless(cells)
    evidence = _evidence(criterion, len(cells))
    solid = (ranked[0].solid,)
    return [Explanation(kind=None, evidence=evidence, criterion=criterion, solids=solid)]


def _whole(cells: Voxels, ground: float, kinds: tuple[Kind, ...]) -> list[Explanation]:
    """Whole fits of every combination of shapes that the kinds know, with and without a name."""
    weights = _weights(cells)
    combinations = sorted({shapes for kind in kinds for shapes in kind.stacks})
    fits = [
        fit_stack(shapes, cells.means, ground, cells.cell_size, weights) for shapes in combinations
    ]
    fits = [fit for fit in fits if _is_whole(fit.state, cells)]
    opinions = colour_opinions([fit.state for fit in fits], cells)
    found = []
    for fit, opinion in zip(fits, opinions, strict=True):
        criterion = fit.bic / len(cells) - _formless(cells)
        evidence = _evidence(criterion, len(cells)) + opinion
        chances: list[tuple[Kind | None, float]] = [
            (kind, _log_chance(fit.state, kind, cells))
            for kind in kinds
            if fit.state.shapes in kind.stacks
        ]
        found += [
            Explanation(
                kind=kind,
                evidence=evidence + chance,
                criterion=criterion,
                stack=fit.state,
                solids=tuple(solids(fit.state)),
            )
            for kind, chance in [*chances, (None, LOG_NO_KIND)]
        ]
    return found


def _is_whole(stack: Stack, cells: Voxels) -> bool:
    """Whether the stack is of the cells' size and all parts above the lowest are seen."""
    extent = float(np.ptp(cells.means, axis=0).max())
    within = max(2.0 * stack.widest.max(), stack.heights[-1] - cells.means[:, 1].min())
    return bool(within < LARGEST_TO_EXTENT * extent and not unseen_parts(stack, cells)[1:].any())


def _log_chance(stack: Stack, kind: Kind, cells: Voxels) -> float:
    """Log of the chance that the ratios of sizes lie within the kind's bounds."""
    widths = np.maximum(stack.widest, 1e-9)
    bounds = [part.slenderness for part in kind.parts]
    ratios = list(stack.slenderness)
    if len(widths) > 1:
        # What holds up a crown and is not seen itself is thin.
        ratios.append(0.0 if unseen_parts(stack, cells)[0] else widths[0] / widths[1])
        bounds.append(kind.ratio)
    return sum(_within(r, limits) for r, limits in zip(ratios, bounds, strict=True) if limits)


def _within(ratio: float, limits: tuple[float, float]) -> float:
    """Log of the chance that a ratio lies within its limits, which blur a little."""
    excess = max(limits[0] - ratio, ratio - limits[1]) / RATIO_SPREAD
    return -np.inf if excess > 2.0 else -float(np.logaddexp(0.0, 2.0 * excess))
