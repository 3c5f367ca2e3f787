"""Hypotheses about upright parts on one axis: the fits of all kinds' shapes, named and unnamed."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Composite, solids
from recon.recognition.fitting.composite_fits import fit_composite, fit_composites
from recon.recognition.fitting.least_squares import Estimate
from recon.recognition.naming.case import Case
from recon.recognition.naming.colour_consistency import colour_opinions
from recon.recognition.naming.curvature import bend_of_outlines
from recon.recognition.naming.hypothesis import Hypothesis, as_kind, rated
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.lead import lead_of_parts, lead_over_shapes
from recon.recognition.naming.limits import RATIO_SPREAD, log_within
from recon.recognition.naming.probability import OTHER_SHAPES, Evidence
from recon.recognition.naming.visibility import coverage, is_whole, unseen_parts
from recon.records import FitFailure, Voxels

Array = NDArray[np.float64]
Pair = tuple[Estimate[Composite], Hypothesis]
"""A fit, and what it says of the cells."""

LOG_NO_KIND = -4.0
"""Log prior of a composite of no kind, relative to one of the catalogue."""
POSSIBLE, CLEAR = 0.05, 0.9
"""Probabilities between which a first fit leaves the name of its kind in doubt."""


def upright(case: Case, kinds: tuple[Kind, ...]) -> list[Hypothesis]:
    """Fits of every combination of shapes in the kinds, named and unnamed.

    All optima of the shapes of a kind compete only where one fit leaves its name in doubt.
    """
    points, size = case.cells.means, case.cells.cell_size
    combinations = sorted({shapes for kind in kinds for shapes in kind.composites})
    fits = {
        shapes: [fit_composite(shapes, points, case.ground, size, case.weights)]
        for shapes in combinations
    }
    found = list(_competing(case, kinds, fits))
    in_doubt = [one.kind for one in found if one.kind and POSSIBLE < one.whole < CLEAR]
    for shapes in {shapes for kind in in_doubt for shapes in kind.composites}:
        fits[shapes] = fit_composites(shapes, points, case.ground, size, case.weights)
    return list(_competing(case, kinds, fits)) if in_doubt else found


def _competing(
    case: Case, kinds: tuple[Kind, ...], fits: dict[tuple[str, ...], list[Estimate[Composite]]]
) -> Iterator[Hypothesis]:
    """The best fit of every combination of shapes as of no kind, and the likeliest of each kind."""
    whole = [fit for each in fits.values() for fit in each if is_whole(fit.state, case.cells)]
    found = _by_colour(case, whole)
    best = {fit.state.shapes: one for fit, one in reversed(found)}
    yield from (replace(one, evidence=one.evidence + LOG_NO_KIND) for one in best.values())
    criteria = {shapes: one.criterion for shapes, one in best.items()}
    for kind in kinds:
        own = [pair for pair in found if pair[0].state.shapes in kind.composites]
        yield from _likeliest(case, kind, own, criteria)


def _likeliest(
    case: Case, kind: Kind, found: list[Pair], criteria: dict[tuple[str, ...], float]
) -> Iterator[Hypothesis]:
    """The fit that is most likely one of a kind, if any may be one."""
    named = [
        (as_kind(case, one, kind, _log_chance(fit.state, kind, case.cells)), fit, one)
        for fit, one in found
    ]
    named = [each for each in named if np.isfinite(each[0].evidence)]
    if not named:
        return
    # The surface is looked at last, as that takes most of the time.
    likely, fit, plain = max(named, key=lambda each: each[0].evidence)
    shapes = fit.state.shapes
    # The same shapes may fit better in a way that is of no kind.
    same = max(one.evidence for rival, one in found if rival.state.shapes == shapes)
    chance = min(1.0, float(np.exp(plain.evidence - LOG_NO_KIND - same)))
    lead = lead_over_shapes(shapes, kind.composites, {**criteria, shapes: plain.criterion})
    chance *= float(OTHER_SHAPES.chance(lead))
    seen = coverage(likely.solids, case.cells)
    one = rated(likely, _evidence(case, fit, likely.criterion, seen))
    yield replace(one, whole=one.whole * chance)


def _by_colour(case: Case, fits: list[Estimate[Composite]]) -> list[Pair]:
    """Fits, with the opinions of the colours."""
    split = case.colours if len(fits) > 1 else FitFailure("no rival")
    opinions = colour_opinions([fit.state for fit in fits], case.cells, split)
    return [(fit, _found(case, fit, o)) for fit, o in zip(fits, opinions, strict=True)]


def _found(case: Case, fit: Estimate[Composite], opinion: float) -> Hypothesis:
    """A fit, with the opinion of the colours."""
    criterion = case.criterion(fit.bic)
    return Hypothesis(
        kind=None,
        evidence=case.evidence(criterion) + opinion,
        criterion=criterion,
        composite=fit.state,
        solids=tuple(solids(fit.state)),
    )


def _evidence(case: Case, fit: Estimate[Composite], criterion: float, seen: Array) -> Evidence:
    """Evidence for a fit of upright parts."""
    rival = case.lone_criterion(case.alone[0]) if case.alone else 0.0
    overall, composite = rival - criterion, fit.state
    counts = np.bincount(composite.nearest(case.cells.means)[1], minlength=len(composite.shapes))
    # The two radii of a cone differ only if there is a layer of cells for each.
    layers = [max(1, len(radii)) for radii in composite.radii]
    narrowest = np.minimum(2.0 * composite.widest, np.diff(composite.heights) / layers)
    return Evidence(
        criterion=criterion,
        # A part makes up for no more than its lead: the rest must not be worse explained.
        lead=max(overall, lead_of_parts(fit, case.cells, case.alone) + min(overall, 0.0)),
        seen=seen,
        widths=narrowest / case.cells.cell_size,
        num_cells=len(case.cells),
        num_cells_above=int(counts[1:].min()),
        num_cells_lowest=int(counts[0]),
        bend=bend_of_outlines(fit, case.cells),
    )


def _log_chance(composite: Composite, kind: Kind, cells: Voxels) -> float:
    """Log probability that the size ratios are within the kind's bounds."""
    widths = np.maximum(composite.widest, 1e-9)
    bounds = [part.slenderness for part in kind.parts]
    ratios = list(composite.slenderness)
    if len(widths) > 1:
        # An unseen part under a crown is thin.
        ratios.append(0.0 if unseen_parts(composite, cells)[0] else widths[0] / widths[1])
        bounds.append(kind.ratio)
    pairs = zip(ratios, bounds, strict=True)
    return sum(log_within(ratio, limits, RATIO_SPREAD) for ratio, limits in pairs if limits)
