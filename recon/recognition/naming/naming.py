"""Naming: the kind of the catalogue that an object is, with a probability."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.colour import mean_hue_deg
from recon.recognition.fitting.composite import solids
from recon.recognition.naming.case import a_case
from recon.recognition.naming.hypotheses import hypotheses
from recon.recognition.naming.hypothesis import Hypothesis
from recon.recognition.naming.kinds import Kind
from recon.recognition.naming.visibility import is_hovering, unseen_parts, with_thin_body
from recon.records import UNKNOWN, FoundObject, Part, Solid, Voxels

Array = NDArray[np.float64]

GHOST_CELLS = 100
"""Cells from which an object above the ground has a hidden foot and is not false matches."""
HOVERING_CELLS = 40
"""Minimum cells of a crown that represents a whole object whose body is not visible."""
NO_KIND_FITS = "no kind of the catalogue fits"
NOT_ASKED = "no catalogue was asked"
NUM_NEAREST = 3
"""Number of nearest kinds that are reported."""
SAID = 0.001
"""Minimum probability of a reported kind."""
LEAST_WHOLE = 1e-6
"""Least probability of being complete, so that its logarithm is finite."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Naming:
    """The name of one object, and the reasons for it."""

    label: str
    probability: float | None
    centre: Array
    size: Array
    parts: tuple[Part, ...] = ()
    failures: list[str] = field(default_factory=list)
    nearest: tuple[tuple[str, float], ...] = ()
    seen: float | None = None
    """Share of its solids' surface covered by cells; None if it has no solids."""
    solid: Solid | None = None
    """The single solid that fits its cells best."""
    deviance: float = 0.0
    """BIC of the cells, minus that of a formless object: the lower, the better explained."""
    is_hovering: bool = False
    """True if nothing visible supports it, and it is too small to stand without."""

    def found(self, number: int, num_voxels: int) -> FoundObject:
        """The record of the object."""
        return FoundObject(
            id=number,
            label=self.label,
            probability=self.probability,
            centre=self.centre,
            size=self.size,
            num_voxels=num_voxels,
            parts=self.parts,
            reason=self.failures[0] if self.failures else None,
            nearest=self.nearest,
            seen=self.seen,
        )


def name_object(
    voxels: Voxels, ground: float, kinds: tuple[Kind, ...], is_metric: bool = False
) -> Naming:
    """Name the object with the cells `voxels`.

    Parameters
    ----------
    ground : float
        Height of the surface it stands on, world.
    is_metric : bool
        Whether lengths are in metres, the unit of the kinds.
    """
    case = a_case(voxels, ground, is_metric)
    found = hypotheses(case, kinds)
    lone = case.alone[0].solid if case.alone else None
    chances = _chances(found)
    ranked = sorted(chances.items(), key=lambda pair: -pair[1][0])
    nearest = tuple((name, chance) for name, (chance, _) in ranked[:NUM_NEAREST] if chance > SAID)
    of_no_kind = 1.0 - sum(chance for chance, _ in chances.values())
    if ranked and ranked[0][1][0] > of_no_kind:
        chance, best = ranked[0][1]
        named = _named(voxels, ground, best, chance)
        return replace(named, nearest=nearest, solid=lone)
    best = max((one for one in found if one.kind is None), key=lambda one: one.evidence)
    unnamed = _unnamed(voxels, ground, best, of_no_kind if kinds else None)
    reason = _reason(ranked[0][1][1] if nearest else None) if kinds else NOT_ASKED
    return replace(unnamed, nearest=nearest, failures=[reason], solid=lone)


def _chances(found: list[Hypothesis]) -> dict[str, tuple[float, Hypothesis]]:
    """Probability of each kind's name, and its most likely hypothesis.

    P(name) = P(kind | it is of a kind) P(complete and sufficiently visible). A kind that the cells
    can hardly be a complete one of takes no share from the others, however well it fits.
    """
    best: dict[str, Hypothesis] = {}
    for one in found:
        if one.kind is not None and np.isfinite(one.evidence):
            rival = best.get(one.kind.name)
            if rival is None or one.evidence > rival.evidence:
                best[one.kind.name] = one
    if not best:
        return {}
    logs = np.array([one.evidence + np.log(max(one.whole, LEAST_WHOLE)) for one in best.values()])
    shares = np.exp(logs - logs.max())
    shares /= shares.sum()
    pairs = zip(best.items(), shares, strict=True)
    return {name: (float(share) * one.whole, one) for (name, one), share in pairs}


def _reason(nearest: Hypothesis | None) -> str:
    """The reason why an object has no name."""
    if nearest is None or nearest.kind is None:
        return NO_KIND_FITS
    return f"too little speaks for the nearest kind, {nearest.kind.name}"


def unknown(voxels: Voxels, ground: float, reason: str) -> Naming:
    """An object without a name or a form, with the reason."""
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    size = high - low
    size[1] = high[1] - ground
    return Naming(
        label=UNKNOWN, probability=None, centre=(low + high) / 2.0, size=size, failures=[reason]
    )


def _unnamed(voxels: Voxels, ground: float, best: Hypothesis, chance: float | None) -> Naming:
    """An object of no kind, with the box of its cell means."""
    roles = ("body", *(f"top {number}" for number in range(1, len(best.solids))))
    box = unknown(voxels, ground, NO_KIND_FITS)
    return replace(
        box,
        probability=chance,
        parts=_parts(voxels, roles, best.solids),
        deviance=best.criterion * len(voxels),
        is_hovering=len(voxels) < GHOST_CELLS and is_hovering(voxels, ground),
    )


def _named(voxels: Voxels, ground: float, best: Hypothesis, chance: float) -> Naming:
    """An object of a kind; upright ones with the box of their solids, others with that of cells."""
    assert best.kind is not None
    box = replace(
        unknown(voxels, ground, ""),
        label=best.kind.name,
        probability=chance,
        failures=[],
        seen=best.seen,
        deviance=best.criterion * len(voxels),
    )
    if best.composite is None:
        roles = best.roles or [part.role for part in best.kind.parts]
        hovers = len(voxels) < HOVERING_CELLS and is_hovering(voxels, ground)
        return replace(box, parts=_parts(voxels, roles, best.solids), is_hovering=hovers)
    composite = with_thin_body(best.composite, voxels)
    held = not unseen_parts(best.composite, voxels)[0] and not is_hovering(voxels, ground)
    width = 2.0 * float(composite.widest.max())
    top = float(composite.heights[-1])
    return replace(
        box,
        centre=np.array([composite.axis[0], (ground + top) / 2.0, composite.axis[1]]),
        size=np.array([width, top - ground, width]),
        parts=_parts(voxels, [part.role for part in best.kind.parts], solids(composite)),
        is_hovering=len(voxels) < HOVERING_CELLS and not held,
    )


def _parts(voxels: Voxels, roles: Sequence[str], found: Sequence[Solid]) -> tuple[Part, ...]:
    """The solids with the properties of the cells nearest to them."""
    if not found:
        return ()
    distances = np.stack([solid.distances(voxels.means) for solid in found])
    nearest = np.argmin(distances, axis=0)
    parts = []
    for number, (role, solid) in enumerate(zip(roles, found, strict=True)):
        own = nearest == number
        rms = float(np.sqrt(np.mean(distances[number, own] ** 2))) if own.any() else 0.0
        hue = mean_hue_deg(voxels.shown_colours[own])
        parts.append(Part(role=role, solid=solid, hue_deg=hue, num_voxels=int(own.sum()), rms=rms))
    return tuple(parts)
