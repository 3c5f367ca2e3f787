"""Which kind of the catalogue an object is: the likeliest of its explanations."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.recognition.colour import mean_hue_deg
from recon.recognition.fitting.composite import solids
from recon.recognition.naming.catalogue import Kind
from recon.recognition.naming.hypotheses import Explanation, explain
from recon.recognition.naming.visibility import is_hovering, unseen_parts, with_thin_body
from recon.records import UNKNOWN, FoundObject, Part, Solid, Voxels

Array = NDArray[np.float64]

GHOST_CELLS = 100
"""Cells from which a thing over the ground is one whose foot is hidden, not false matches."""
HOVERING_CELLS = 40
"""Cells that a crown needs to stand for a whole object whose body is not seen."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Naming:
    """What one object was found to be."""

    label: str
    probability: float
    centre: Array
    size: Array
    parts: tuple[Part, ...] = ()
    failures: list[str] = field(default_factory=list)
    deviance: float = 0.0
    """BIC of the cells, less what a thing of no form would leave: the lower, the better known."""
    is_hovering: bool = False
    """Whether nothing that is seen holds it, and it is too small to do without."""

    def found(self, number: int, num_voxels: int) -> FoundObject:
        """The record of it."""
        return FoundObject(
            id=number,
            label=self.label,
            probability=self.probability,
            centre=self.centre,
            size=self.size,
            num_voxels=num_voxels,
            parts=self.parts,
        )


def name_object(voxels: Voxels, ground: float, kinds: tuple[Kind, ...]) -> Naming:
    """Name the object that `voxels` are the cells of.

    Parameters
    ----------
    ground : float
        Height it stands on, world.
    """
    explanations = explain(voxels, ground, kinds)
    logs = np.array([one.evidence for one in explanations])
    shares = np.exp(logs - logs.max())
    best = explanations[int(np.argmax(logs))]
    alike = np.array([one.kind is best.kind for one in explanations])
    probability = float(shares[alike].sum() / shares.sum())
    if best.kind is None:
        return _unnamed(voxels, ground, best, probability)
    return _named(voxels, ground, best, best.kind, probability)


def unknown(voxels: Voxels, ground: float, reason: str) -> Naming:
    """An object without a name or a form, for that reason."""
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    size = high - low
    size[1] = high[1] - ground
    return Naming(
        label=UNKNOWN, probability=1.0, centre=(low + high) / 2.0, size=size, failures=[reason]
    )


def _unnamed(voxels: Voxels, ground: float, best: Explanation, probability: float) -> Naming:
    """An object of no kind, in the box of its cell means."""
    roles = ("body", *(f"top {number}" for number in range(1, len(best.solids))))
    box = unknown(voxels, ground, "no kind of the catalogue fits")
    return Naming(
        label=UNKNOWN,
        probability=probability,
        centre=box.centre,
        size=box.size,
        parts=_parts(voxels, roles, best.solids),
        failures=box.failures,
        deviance=best.criterion * len(voxels),
        is_hovering=len(voxels) < GHOST_CELLS and is_hovering(voxels, ground),
    )


def _named(
    voxels: Voxels, ground: float, best: Explanation, kind: Kind, probability: float
) -> Naming:
    """An object of a kind, in the box of its solids."""
    assert best.stack is not None
    stack = with_thin_body(best.stack, voxels)
    held = not unseen_parts(best.stack, voxels)[0] and not is_hovering(voxels, ground)
    width = 2.0 * float(stack.widest.max())
    top = float(stack.heights[-1])
    return Naming(
        label=kind.name,
        probability=probability,
        centre=np.array([stack.axis[0], (ground + top) / 2.0, stack.axis[1]]),
        size=np.array([width, top - ground, width]),
        parts=_parts(voxels, [part.role for part in kind.parts], solids(stack)),
        deviance=best.criterion * len(voxels),
        is_hovering=len(voxels) < HOVERING_CELLS and not held,
    )


def _parts(voxels: Voxels, roles: Sequence[str], found: Sequence[Solid]) -> tuple[Part, ...]:
    """The solids with what their own cells, those nearest to them, say."""
    if not found:
        return ()
    distances = np.stack([solid.distances(voxels.means) for solid in found])
    nearest = np.argmin(distances, axis=0)
    parts = []
    for number, (role, solid) in enumerate(zip(roles, found, strict=True)):
        own = nearest == number
        rms = float(np.sqrt(np.mean(distances[number, own] ** 2))) if own.any() else 0.0
        hue = mean_hue_deg(voxels.colours[own])
        parts.append(Part(role=role, solid=solid, hue_deg=hue, num_voxels=int(own.sum()), rms=rms))
    return tuple(parts)
