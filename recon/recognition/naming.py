"""Which kind of the catalogue an object is: whole-object fits compared by BIC."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.recognition.catalogue import Kind
from recon.recognition.colour import mean_hue_deg
from recon.recognition.least_squares import Estimate
from recon.recognition.stacks import Stack, StackModel, fit_stack, solids
from recon.records import UNKNOWN, FoundObject, Part, Voxels

Array = NDArray[np.float64]

NOISE_FLOOR = 0.05
"""Smallest noise believed of a cell's mean, in cells."""
WIDEST_NOISE = 0.5
"""Scale of the residuals, in cells, over which no kind is believed to fit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Naming:
    """What one object was found to be."""

    label: str
    probability: float
    centre: Array
    size: Array
    parts: tuple[Part, ...] = ()
    failures: list[str] = field(default_factory=list)

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
    shapes = sorted({stack for kind in kinds for stack in kind.stacks})
    weights = np.clip(voxels.counts / np.median(voxels.counts), 0.1, 4.0)
    floor = NOISE_FLOOR * voxels.cell_size
    fits = {stack: fit_stack(stack, voxels.means, ground, floor, weights) for stack in shapes}
    candidates = [
        (fits[stack].bic - 2.0 * _log_ratio_chance(fits[stack], kind), kind, fits[stack])
        for kind in kinds
        for stack in kind.stacks
    ]
    criterion, kind, fit = min(candidates, key=lambda candidate: candidate[0])
    if fit.sigma > WIDEST_NOISE * voxels.cell_size:
        return unknown(voxels, ground, "no kind of the catalogue fits")
    evidence = np.array([np.exp(-0.5 * (value - criterion)) for value, _, _ in candidates])
    own = np.array([other is kind for _, other, _ in candidates])
    centre, size = _box(fit.state)
    return Naming(
        label=kind.name,
        probability=float(evidence[own].sum() / evidence.sum()),
        centre=centre,
        size=size,
        parts=_parts(voxels, kind, fit),
    )


def unknown(voxels: Voxels, ground: float, reason: str) -> Naming:
    """An object without a name, in the box of its cell means."""
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    size = high - low
    size[1] = high[1] - ground
    return Naming(
        label=UNKNOWN, probability=0.0, centre=(low + high) / 2.0, size=size, failures=[reason]
    )


def _log_ratio_chance(fit: Estimate[Stack], kind: Kind) -> float:
    """Log of the chance that the ratio of radii lies within the kind's bounds."""
    if kind.ratio is None or len(kind.parts) < 2:
        return 0.0
    ratio = fit.state.widest[0] / max(fit.state.widest[1], 1e-9)
    low, high = kind.ratio
    excess = max(low - ratio, ratio - high, 0.0)
    return -20.0 * float(excess)


def _box(stack: Stack) -> tuple[Array, Array]:
    width = 2.0 * float(stack.widest.max())
    bottom, top = stack.heights[0], stack.heights[-1]
    centre = np.array([stack.axis[0], (bottom + top) / 2.0, stack.axis[1]])
    return centre, np.array([width, top - bottom, width])


def _parts(voxels: Voxels, kind: Kind, fit: Estimate[Stack]) -> tuple[Part, ...]:
    residuals, _, nearest = StackModel(voxels.means).nearest(fit.state)
    parts = []
    for number, (rule, solid) in enumerate(zip(kind.parts, solids(fit.state), strict=True)):
        own = nearest == number
        rms = float(np.sqrt(np.mean(residuals[own] ** 2))) if own.any() else 0.0
        hue = mean_hue_deg(voxels.colours[own])
        parts.append(
            Part(role=rule.role, solid=solid, hue_deg=hue, num_voxels=int(own.sum()), rms=rms)
        )
    return tuple(parts)
