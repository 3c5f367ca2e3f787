"""Hypotheses about cells: each kind of the catalogue, one solid of no kind, or nothing."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.composite import Composite, fit_composite, solids
from recon.recognition.fitting.least_squares import Estimate
from recon.recognition.naming.assembly import Assembly, assemblies
from recon.recognition.naming.case import Case
from recon.recognition.naming.colour_consistency import colour_opinions
from recon.recognition.naming.curvature import bend
from recon.recognition.naming.descriptors import describe
from recon.recognition.naming.flat_rival import flat_rival
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.lead import lead_of_parts, lead_over_shapes
from recon.recognition.naming.limits import (
    RATIO_SPREAD,
    hue_chance,
    log_within,
    size_chance,
    slenderness_chance,
    solid_sizes,
)
from recon.recognition.naming.probability import (
    FILLED,
    FLAT,
    FORM,
    FORMED,
    LEAD,
    NEARNESS,
    ORDERED,
    OTHER_SHAPES,
    Evidence,
)
from recon.recognition.naming.visibility import coverage, is_hovering, is_whole, unseen_parts
from recon.records import Solid, Voxels

Array = NDArray[np.float64]

LOG_NO_KIND = -4.0
"""Log prior of a composite of no kind, relative to one of the catalogue."""
CLEAR = 0.9
"""Probability of a fit on one axis above which planes and bars are not tried."""
LEAST_WHOLE = 0.1
"""Probability below which a fit gives no name anyway."""
ALSO_FITS = {"sphere": {"ellipsoid"}, "cylinder": {"cone", "truncated cone"}}
"""Solids that fit everything a simpler one fits, so they do not compete with it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """One interpretation of the cells, and how likely it is."""

    kind: Kind | None
    """None = of no kind."""
    evidence: float
    """Log likelihood, up to a constant per object."""
    criterion: float
    """BIC per cell, minus that of a formless object: the lower, the better the cells are
    explained."""
    whole: float = 0.0
    """Probability that it is of its kind, complete and sufficiently visible, if it is of a kind."""
    seen: float | None = None
    """Share of its solids' surface covered by cells."""
    composite: Composite | None = None
    """The composite fit; None for a single solid or none."""
    solids: tuple[Solid, ...] = ()
    """From the ground up."""
    roles: tuple[str, ...] = ()
    """Roles of the solids, if these are not one per part of the kind."""


def hypotheses(case: Case, kinds: tuple[Kind, ...]) -> list[Hypothesis]:
    """All hypotheses about the cells of one object, including that it is unknown."""
    upright = tuple(kind for kind in kinds if kind.is_upright and len(kind.parts) > 1)
    found = [
        *_upright(case, upright),
        *_lone(case, [kind for kind in kinds if len(kind.parts) == 1]),
    ]
    is_clear = any(one.whole > CLEAR for one in found if np.isfinite(one.evidence))
    return [
        *(found if is_clear else _against_planes(case, found)),
        *_assembled(case, () if is_clear else kinds, found),
        *_learned(case, [kind for kind in kinds if kind.learned]),
        Hypothesis(kind=None, evidence=case.evidence(0.0), criterion=0.0),
        *_of_no_kind(case),
    ]


def _of_no_kind(case: Case) -> Iterator[Hypothesis]:
    """A single solid, if the cells extend down to the ground."""
    if case.alone and not is_hovering(case.cells, case.ground):
        best = case.alone[0]
        criterion = case.lone_criterion(best)
        yield Hypothesis(
            kind=None,
            evidence=case.evidence(criterion),
            criterion=criterion,
            solids=(best.solid,),
        )


def _upright(case: Case, kinds: tuple[Kind, ...]) -> Iterator[Hypothesis]:
    """Fits of every combination of shapes in the kinds, named and unnamed."""
    cells, ground = case.cells, case.ground
    combinations = sorted({shapes for kind in kinds for shapes in kind.composites})
    fits = [
        fit_composite(shapes, cells.means, ground, cells.cell_size, case.weights)
        for shapes in combinations
    ]
    fits = [fit for fit in fits if is_whole(fit.state, cells)]
    opinions = colour_opinions([fit.state for fit in fits], cells)
    criteria = {fit.state.shapes: case.criterion(fit.bic) for fit in fits}
    for fit, opinion in zip(fits, opinions, strict=True):
        criterion = criteria[fit.state.shapes]
        found = Hypothesis(
            kind=None,
            evidence=case.evidence(criterion) + opinion,
            criterion=criterion,
            composite=fit.state,
            solids=tuple(solids(fit.state)),
        )
        yield replace(found, evidence=found.evidence + LOG_NO_KIND)
        own = [kind for kind in kinds if fit.state.shapes in kind.composites]
        chances = [_log_chance(fit.state, kind, cells) for kind in own]
        if np.isfinite(chances).any():
            evidence = _evidence(case, fit, criterion, coverage(found.solids, cells))
            for kind, chance in zip(own, chances, strict=True):
                rated = _rated(case, found, kind, chance, evidence)
                lead = lead_over_shapes(fit.state.shapes, kind.composites, criteria)
                yield replace(rated, whole=rated.whole * float(OTHER_SHAPES.chance(lead)))


def _against_planes(case: Case, found: list[Hypothesis]) -> Iterator[Hypothesis]:
    """Fits, on one axis less likely if planes explain the cells better: a box on a box."""
    rival = flat_rival(case) if any(one.whole > LEAST_WHOLE for one in found) else 0.0
    for one in found:
        lead = rival - one.criterion if one.composite else np.inf
        yield replace(one, whole=one.whole * float(FORMED.chance(lead)))


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
    )


def _rated(
    case: Case, found: Hypothesis, kind: Kind, chance: float, evidence: Evidence
) -> Hypothesis:
    """A fit as one of a kind: as likely as its sizes, its hues and what is seen allow."""
    looks = hue_chance(kind.parts, found.solids, case.cells)
    shape = found.composite or case
    looks *= slenderness_chance(kind, shape.overall_slenderness)
    if case.is_metric:
        looks *= size_chance(kind, kind.parts, list(map(solid_sizes, found.solids)), case.cells)
    seen = float(evidence.seen.mean())
    # Only ratios beyond their bounds speak against a kind: on a bound the chance is a half.
    within = min(1.0, 2.0 * float(np.exp(chance)))
    return replace(
        found,
        kind=kind,
        evidence=found.evidence + chance + float(np.log(max(looks, 1e-9))),
        whole=evidence.probability * looks * within if seen >= kind.min_seen else 0.0,
        seen=seen,
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


def _lone(case: Case, kinds: list[Kind]) -> Iterator[Hypothesis]:
    """Kinds of a single solid in any orientation."""
    for kind in kinds:
        rule = kind.parts[0]
        for one in case.alone:
            shape = one.solid.kind
            if shape.removeprefix("truncated ") not in rule.shapes:
                continue
            others = {shape, *rule.shapes, *ALSO_FITS.get(shape, ())}
            rivals = [other for other in case.alone if other.solid.kind not in others]
            criterion = case.lone_criterion(one)
            rival = min(map(case.lone_criterion, rivals), default=0.0)
            seen = coverage([one.solid], case.cells)
            width = float(np.ptp(case.cells.means, axis=0).min()) / case.cells.cell_size
            evidence = Evidence(
                criterion=criterion,
                lead=rival - criterion,
                seen=seen,
                widths=np.array([width]),
                num_cells=len(case.cells),
                num_cells_above=len(case.cells),
            )
            filled = case.filled(one.solid)
            found = Hypothesis(
                kind=None,
                evidence=case.evidence(filled * criterion),
                criterion=criterion,
                solids=(one.solid,),
            )
            rated = _rated(case, found, kind, 0.0, evidence)
            yield replace(rated, whole=rated.whole * float(FILLED.chance(filled)))


def _assembled(case: Case, kinds: tuple[Kind, ...], fits: list[Hypothesis]) -> Iterator[Hypothesis]:
    """Kinds with parts beside and under each other, each with its best assembly.

    Hovering cells have none, since what supports them is not among the parts.

    Parameters
    ----------
    fits : list of Hypothesis
        The fits on one axis, which compete with upright planes; a board is also a flat ellipsoid.
    """
    if is_hovering(case.cells, case.ground):
        return
    rival = min((one.criterion for one in fits if one.composite), default=0.0)
    for kind in kinds:
        if len(kind.parts) > 1 and not kind.is_upright:
            found = [_ordered(case, one, rival) for one in assemblies(case.ways(kind), kind)]
            yield from sorted(found, key=lambda one: -one.whole)[:1]


def _ordered(case: Case, one: Assembly, rival: float) -> Hypothesis:
    """An assembly as an object of its kind; `rival`: criterion of the best fit on one axis."""
    criterion = case.dense_criterion(one.bic) + one.cost
    chance = float(FORM.chance(-criterion)) * _lead_chance(case, one, criterion) * one.explained
    if one.upright:
        chance *= float(FORMED.chance(rival - criterion))
        chance *= float(FLAT.chance(-bend(case.dense, one.upright)))
    if one.is_outer:
        chance *= float(FORMED.chance(case.flat_criterion - criterion))
    looks = hue_chance(one.rules, one.solids, case.dense)
    looks *= slenderness_chance(one.kind, case.overall_slenderness)
    if case.is_metric:
        looks *= size_chance(one.kind, one.rules, one.sizes(case.dense), case.dense)
    return Hypothesis(
        kind=one.kind,
        evidence=case.evidence(criterion) + float(np.log(max(looks, 1e-9))),
        criterion=criterion,
        whole=chance * looks if one.seen >= one.kind.min_seen else 0.0,
        seen=one.seen,
        solids=one.solids,
        roles=one.roles,
    )


def _lead_chance(case: Case, one: Assembly, criterion: float) -> float:
    """Chance that an assembly is more than one solid, which several always explain no worse."""
    if one.has_planes:
        return float(ORDERED.chance(case.seen_criterion - criterion))
    return float(LEAD.chance(case.dense_lone_criterion - criterion))


def _learned(case: Case, kinds: list[Kind]) -> Iterator[Hypothesis]:
    """Kinds learned from examples."""
    described = describe(case.cells) if kinds else {}
    for kind in kinds:
        if kind.learned is not None:
            distance = kind.learned.distance(described) / kind.learned.threshold
            chance = float(NEARNESS.chance(-np.log(max(distance, 1e-9))))
            yield Hypothesis(
                kind=kind,
                evidence=-0.5 * (2.0 * distance) ** 2,
                criterion=0.0,
                whole=kind.learned.believed(chance),
            )
