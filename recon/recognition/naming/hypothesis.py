"""A hypothesis about the cells of an object, and its rating as one of a kind."""

from dataclasses import dataclass, replace

import numpy as np

from recon.recognition.fitting.composite import Composite
from recon.recognition.naming.case import Case
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.limits import (
    hue_chance,
    proportion_chance,
    size_chance,
    solid_sizes,
)
from recon.recognition.naming.probability import Evidence
from recon.records import Solid


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


def as_kind(case: Case, found: Hypothesis, kind: Kind, chance: float) -> Hypothesis:
    """A fit as one of a kind: as likely as its sizes and its hues allow.

    Parameters
    ----------
    chance : float
        Log probability of its ratios.
    """
    looks = hue_chance(kind.parts, found.solids, case.cells)
    shape = found.composite or case
    looks *= proportion_chance(kind, shape.overall_slenderness, case.elongation)
    if case.is_metric:
        looks *= size_chance(kind, kind.parts, list(map(solid_sizes, found.solids)), case.cells)
    # Only ratios beyond their bounds speak against a kind: on a bound the chance is a half.
    within = min(1.0, 2.0 * float(np.exp(chance)))
    return replace(
        found,
        kind=kind,
        evidence=found.evidence + chance + float(np.log(max(looks, 1e-9))),
        whole=looks * within,
    )


def rated(found: Hypothesis, evidence: Evidence) -> Hypothesis:
    """A fit as one of its kind, as likely as what is seen of it also allows."""
    assert found.kind is not None
    seen = float(evidence.seen.mean())
    is_enough = seen >= found.kind.min_seen
    return replace(found, whole=found.whole * evidence.probability if is_enough else 0.0, seen=seen)
