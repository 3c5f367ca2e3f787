"""Hypotheses about cells: each kind of the catalogue, one solid of no kind, or nothing."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming.assembly import Assembly, assemblies
from recon.recognition.naming.case import Case
from recon.recognition.naming.curvature import bend
from recon.recognition.naming.descriptors import describe
from recon.recognition.naming.flat_rival import flat_rival
from recon.recognition.naming.hypothesis import Hypothesis, as_kind, rated
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.limits import (
    hue_chance,
    proportion_chance,
    size_chance,
)
from recon.recognition.naming.probability import (
    FILLED,
    FLAT,
    FORM,
    FORMED,
    LEAD,
    MANY,
    NEARNESS,
    ORDERED,
    Evidence,
)
from recon.recognition.naming.upright import CLEAR, upright
from recon.recognition.naming.visibility import coverage, is_hovering

Array = NDArray[np.float64]

LEAST_WHOLE = 0.1
"""Probability below which a fit gives no name anyway."""
ALSO_FITS = {"sphere": {"ellipsoid"}, "cylinder": {"cone", "truncated cone"}}
"""Solids that fit everything a simpler one fits, so they do not compete with it."""


def hypotheses(case: Case, kinds: tuple[Kind, ...]) -> list[Hypothesis]:
    """All hypotheses about the cells of one object, including that it is unknown."""
    composite = tuple(kind for kind in kinds if kind.is_upright and len(kind.parts) > 1)
    found = [
        *upright(case, composite),
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


def _against_planes(case: Case, found: list[Hypothesis]) -> Iterator[Hypothesis]:
    """Fits, on one axis less likely if planes explain the cells better: a box on a box."""
    rival = flat_rival(case) if any(one.whole > LEAST_WHOLE for one in found) else 0.0
    for one in found:
        lead = rival - one.criterion if one.composite else np.inf
        yield replace(one, whole=one.whole * float(FORMED.chance(lead)))


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
                num_cells_lowest=len(case.cells),
            )
            filled = case.filled(one.solid)
            found = Hypothesis(
                kind=None,
                evidence=case.evidence(filled * criterion),
                criterion=criterion,
                solids=(one.solid,),
            )
            named = rated(as_kind(case, found, kind, 0.0), evidence)
            yield replace(named, whole=named.whole * float(FILLED.chance(filled)))


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
            ways = assemblies(case.ways(kind), kind, case.ground)
            found = [_ordered(case, one, rival) for one in ways]
            yield from sorted(found, key=lambda one: -one.whole)[:1]


def _ordered(case: Case, one: Assembly, rival: float) -> Hypothesis:
    """An assembly as an object of its kind; `rival`: criterion of the best fit on one axis."""
    criterion = case.dense_criterion(one.bic) + one.cost
    chance = float(FORM.chance(-criterion)) * _lead_chance(case, one, criterion) * one.explained
    chance *= float(MANY.chance(np.log(len(case.cells))))
    if one.upright:
        chance *= float(FORMED.chance(rival - criterion))
        chance *= float(FLAT.chance(-bend(case.dense, one.upright)))
    if one.is_outer:
        chance *= float(FORMED.chance(case.flat_criterion - criterion))
    looks = hue_chance(one.rules, one.solids, case.dense)
    looks *= proportion_chance(one.kind, case.overall_slenderness, case.elongation)
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
