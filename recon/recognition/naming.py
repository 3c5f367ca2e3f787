"""Which kind of the catalogue an object is: whole-object fits compared by their evidence."""

from dataclasses import dataclass, field, replace

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
UNKNOWN_NOISE = 0.5
"""Scale of the residuals, in cells, that a thing of no known kind would leave."""
MOST_CELLS = 2000
"""Cells a fit is made on: more do not change it."""
INDEPENDENT_CELLS = 60.0
"""Cells of an object err together: all of them weigh no more than so many that do not. Set where
probabilities come true over simulated orbits."""
RATIO_SPREAD = 0.05
"""Standard deviation of the ratio of two radii over which a bound of the catalogue blurs."""
UNSEEN = 0.1
"""A part is unseen that has less of its surface in cells than this share of the best seen one."""
TRUNK = 0.3
"""Radius of a body that is not seen, as a share of its crown's."""
LARGEST_TO_EXTENT = 2.0
"""A fit larger than so many times the extent of its cells is none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Naming:
    """What one object was found to be."""

    label: str
    probability: float
    centre: Array
    size: Array
    parts: tuple[Part, ...] = ()
    failures: list[str] = field(default_factory=list)
    deviance: float = np.inf
    """Minus twice the log likelihood of the cells."""

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """One kind in one combination of shapes."""

    kind: Kind
    fit: Estimate[Stack]
    evidence: float
    """Log of it, up to a constant of the object."""


def name_object(voxels: Voxels, ground: float, kinds: tuple[Kind, ...]) -> Naming:
    """Name the object that `voxels` are the cells of.

    Parameters
    ----------
    ground : float
        Height it stands on, world.
    """
    cells = _thinned(voxels)
    hypotheses = _hypotheses(cells, ground, kinds)
    if not hypotheses:
        return unknown(voxels, ground, "an object shows only one part")
    best = max(hypotheses, key=lambda one: one.evidence)
    nothing = _evidence(_unknown_deviance(cells), len(cells))
    logs = np.array([one.evidence for one in hypotheses] + [nothing])
    shares = np.exp(logs - logs.max())
    own = np.array([one.kind is best.kind for one in hypotheses] + [False])
    probability = float(shares[own].sum() / shares.sum())
    if nothing > best.evidence:
        return unknown(voxels, ground, "no kind of the catalogue fits", probability)
    return _named(voxels, best, probability)


def unknown(voxels: Voxels, ground: float, reason: str, chance: float = 0.0) -> Naming:
    """An object without a name, in the box of its cell means.

    Parameters
    ----------
    chance : float
        That it is of a kind of the catalogue after all.
    """
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    size = high - low
    size[1] = high[1] - ground
    return Naming(
        label=UNKNOWN,
        probability=1.0 - chance,
        centre=(low + high) / 2.0,
        size=size,
        failures=[reason],
        deviance=_unknown_deviance(voxels),
    )


def _thinned(voxels: Voxels) -> Voxels:
    if len(voxels) <= MOST_CELLS:
        return voxels
    rows = np.random.default_rng(0).choice(len(voxels), MOST_CELLS, replace=False)
    return voxels.select(np.sort(rows))


def _hypotheses(voxels: Voxels, ground: float, kinds: tuple[Kind, ...]) -> list[Hypothesis]:
    # Cells of few points lie off the surface more often than on it.
    weights = np.clip(voxels.counts / np.median(voxels.counts), 0.1, 4.0)
    floor = NOISE_FLOOR * voxels.cell_size
    shapes = sorted({stack for kind in kinds for stack in kind.stacks})
    fits = {stack: fit_stack(stack, voxels.means, ground, floor, weights) for stack in shapes}
    whole = {stack: fit for stack, fit in fits.items() if _is_whole(fit, voxels)}
    return [
        Hypothesis(
            kind=kind,
            fit=whole[stack],
            evidence=_evidence(whole[stack].bic, len(voxels))
            + _log_chance(whole[stack], kind, voxels),
        )
        for kind in kinds
        for stack in kind.stacks
        if stack in whole
    ]


def _is_whole(fit: Estimate[Stack], voxels: Voxels) -> bool:
    """Whether the stack is of the cells' size and all parts above the lowest are seen."""
    stack = fit.state
    extent = float(np.ptp(voxels.means, axis=0).max())
    within = max(2.0 * stack.widest.max(), stack.heights[-1] - voxels.means[:, 1].min())
    return bool(within < LARGEST_TO_EXTENT * extent and not _is_unseen(stack, voxels)[1:].any())


def _is_unseen(stack: Stack, voxels: Voxels) -> NDArray[np.bool_]:
    """(parts,) which parts have next to no cells for their surface."""
    _, _, nearest = StackModel(voxels.means).nearest(stack)
    cells = np.bincount(nearest, minlength=len(stack.shapes))
    density = cells / np.maximum(stack.areas, voxels.cell_size**2)
    unseen: NDArray[np.bool_] = density < UNSEEN * density.max()
    return unseen


def _evidence(criterion: float, num_cells: int) -> float:
    return -0.5 * criterion * min(1.0, INDEPENDENT_CELLS / num_cells)


def _unknown_deviance(voxels: Voxels) -> float:
    """That of Student-t residuals of the scale `UNKNOWN_NOISE`, as they fall on average."""
    # (nu + 1) E[log(1 + t^2 / nu)] of nu = 3 degrees of freedom is 2.27.
    scale = UNKNOWN_NOISE * voxels.cell_size
    return len(voxels) * (2.27 + 2.0 * float(np.log(scale)))


def _log_chance(fit: Estimate[Stack], kind: Kind, voxels: Voxels) -> float:
    """Log of the chance that the ratio of radii lies within the kind's bounds."""
    if kind.ratio is None or len(kind.parts) < 2:
        return 0.0
    widths = fit.state.widest
    # What holds up a crown and is not seen itself is thin.
    ratio = 0.0 if _is_unseen(fit.state, voxels)[0] else widths[0] / max(widths[1], 1e-9)
    excess = max(kind.ratio[0] - ratio, ratio - kind.ratio[1]) / RATIO_SPREAD
    return -float(np.logaddexp(0.0, 2.0 * excess))


def _named(voxels: Voxels, best: Hypothesis, probability: float) -> Naming:
    stack = _with_thin_body(best.fit.state, voxels)
    width = 2.0 * float(stack.widest.max())
    bottom, top = stack.heights[0], stack.heights[-1]
    return Naming(
        label=best.kind.name,
        probability=probability,
        centre=np.array([stack.axis[0], (bottom + top) / 2.0, stack.axis[1]]),
        size=np.array([width, top - bottom, width]),
        parts=_parts(voxels, best.kind, stack),
        deviance=best.fit.bic,
    )


def _with_thin_body(stack: Stack, voxels: Voxels) -> Stack:
    """The stack, its lowest part no wider than a trunk where it is not seen."""
    if not _is_unseen(stack, voxels)[0] or not len(stack.radii[0]):
        return stack
    radius = np.minimum(stack.radii[0], TRUNK * stack.widest[1:].max(initial=0.0))
    return replace(stack, radii=(radius, *stack.radii[1:]))


def _parts(voxels: Voxels, kind: Kind, stack: Stack) -> tuple[Part, ...]:
    residuals, _, nearest = StackModel(voxels.means).nearest(stack)
    parts = []
    for number, (rule, solid) in enumerate(zip(kind.parts, solids(stack), strict=True)):
        own = nearest == number
        rms = float(np.sqrt(np.mean(residuals[own] ** 2))) if own.any() else 0.0
        hue = mean_hue_deg(voxels.colours[own])
        parts.append(
            Part(role=rule.role, solid=solid, hue_deg=hue, num_voxels=int(own.sum()), rms=rms)
        )
    return tuple(parts)
