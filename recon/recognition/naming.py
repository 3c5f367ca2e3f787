"""Which kind of the catalogue an object is: whole-object fits compared by their evidence."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.catalogue import Kind
from recon.recognition.colour import mean_hue_deg
from recon.recognition.least_squares import Estimate
from recon.recognition.shapes import SAMPLE, candidates
from recon.recognition.stacks import Stack, StackModel, fit_stack, solids
from recon.records import UNKNOWN, FitFailure, FoundObject, Part, Solid, Voxels

Array = NDArray[np.float64]
Shapes = tuple[str, ...]

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
"""Standard deviation of a ratio of sizes, over which the bounds of the catalogue blur."""
UNSEEN = 0.1
"""A part is unseen that has less of its surface in cells than this share of the best seen one."""
HOVERING = 0.15
"""Share of its height that an object's lowest cell may be over the ground: what hovers higher is
held by something that is not seen, and is more than one solid."""
LOG_NO_KIND = -4.0
"""Log of how much rarer a stack of no kind is than one of the catalogue."""
GHOST_CELLS = 100
"""Cells from which a thing over the ground is one whose foot is hidden, not false matches."""
HOVERING_CELLS = 40
"""Cells that a crown needs to stand for a whole object whose body is not seen."""
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
    fits = _stacks(cells, ground, kinds)
    hypotheses = _hypotheses(cells, fits, kinds)
    nameless = _nameless(cells, ground, fits)
    logs = np.array([one.evidence for one in hypotheses] + [nameless.evidence])
    shares = np.exp(logs - logs.max())
    best = int(np.argmax(logs))
    if best == len(hypotheses):
        return _unnamed(voxels, ground, nameless, float(shares[-1] / shares.sum()))
    kind = hypotheses[best].kind
    own = np.array([one.kind is kind for one in hypotheses] + [False])
    return _named(voxels, hypotheses[best], float(shares[own].sum() / shares.sum()))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nameless:
    """The best explanation of cells that needs no name."""

    evidence: float
    criterion: float
    """BIC a cell."""
    solids: tuple[Solid, ...]
    """From the ground up; empty where nothing fits."""


def _nameless(cells: Voxels, ground: float, fits: dict[Shapes, Estimate[Stack]]) -> Nameless:
    """Nothing, one solid that stands on the ground, or a stack of no kind."""
    count = len(cells)
    nothing = _unknown_deviance(cells)
    found: list[tuple[float, float, tuple[Solid, ...]]] = [
        (_evidence(nothing, count), nothing / count, ())
    ]
    found += [
        (_evidence(fit.bic, count) + LOG_NO_KIND, fit.bic / count, tuple(solids(fit.state)))
        for fit in fits.values()
    ]
    ranked = candidates(cells.means, _weights(cells))
    if not _is_hovering(cells, ground) and not isinstance(ranked, FitFailure):
        criterion = ranked[0].bic / min(count, SAMPLE)
        found.append((_evidence(criterion * count, count), criterion, (ranked[0].solid,)))
    evidence, criterion, parts = max(found, key=lambda one: one[0])
    return Nameless(evidence=evidence, criterion=criterion, solids=parts)


def _is_hovering(cells: Voxels, ground: float) -> bool:
    """Whether no cell is near the ground."""
    low, high = cells.means[:, 1].min(), cells.means[:, 1].max()
    return bool(low - ground > HOVERING * (high - ground) + 2.0 * cells.cell_size)


def _unnamed(voxels: Voxels, ground: float, found: Nameless, probability: float) -> Naming:
    """An object of no kind, in the box of its cell means."""
    low, high = voxels.means.min(axis=0), voxels.means.max(axis=0)
    size = high - low
    size[1] = high[1] - ground
    roles = ("body", *(f"top {number}" for number in range(1, len(found.solids))))
    return Naming(
        label=UNKNOWN,
        probability=probability,
        centre=(low + high) / 2.0,
        size=size,
        parts=_parts(voxels, roles, found.solids),
        failures=["no kind of the catalogue fits"],
        is_hovering=len(voxels) < GHOST_CELLS and _is_hovering(voxels, ground),
        deviance=found.criterion * len(voxels) - _unknown_deviance(voxels),
    )


def unknown(voxels: Voxels, ground: float, reason: str) -> Naming:
    """An object without a name or a solid, for that reason."""
    nothing = Nameless(evidence=0.0, criterion=0.0, solids=())
    return replace(_unnamed(voxels, ground, nothing, 0.0), failures=[reason], deviance=0.0)


def _thinned(voxels: Voxels) -> Voxels:
    if len(voxels) <= MOST_CELLS:
        return voxels
    rows = np.random.default_rng(0).choice(len(voxels), MOST_CELLS, replace=False)
    return voxels.select(np.sort(rows))


def _stacks(
    voxels: Voxels, ground: float, kinds: tuple[Kind, ...]
) -> dict[Shapes, Estimate[Stack]]:
    """The whole fits of every combination of shapes that the kinds know."""
    weights, floor = _weights(voxels), NOISE_FLOOR * voxels.cell_size
    shapes = sorted({stack for kind in kinds for stack in kind.stacks})
    fits = {stack: fit_stack(stack, voxels.means, ground, floor, weights) for stack in shapes}
    return {stack: fit for stack, fit in fits.items() if _is_whole(fit, voxels)}


def _hypotheses(
    voxels: Voxels, fits: dict[Shapes, Estimate[Stack]], kinds: tuple[Kind, ...]
) -> list[Hypothesis]:
    return [
        Hypothesis(
            kind=kind,
            fit=fits[stack],
            evidence=_evidence(fits[stack].bic, len(voxels))
            + _log_chance(fits[stack].state, kind, voxels),
        )
        for kind in kinds
        for stack in kind.stacks
        if stack in fits
    ]


def _weights(voxels: Voxels) -> Array:
    """Cells of few points lie off the surface more often than on it."""
    weights: Array = np.clip(voxels.counts / np.median(voxels.counts), 0.1, 4.0)
    return weights


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


def _log_chance(stack: Stack, kind: Kind, voxels: Voxels) -> float:
    """Log of the chance that the ratios of sizes lie within the kind's bounds."""
    widths = np.maximum(stack.widest, 1e-9)
    bounds = [part.slenderness for part in kind.parts]
    ratios = list(stack.slenderness)
    if len(widths) > 1:
        # What holds up a crown and is not seen itself is thin.
        ratios.append(0.0 if _is_unseen(stack, voxels)[0] else widths[0] / widths[1])
        bounds.append(kind.ratio)
    return sum(_within(r, limits) for r, limits in zip(ratios, bounds, strict=True) if limits)


def _within(ratio: float, limits: tuple[float, float]) -> float:
    """Log of the chance that a ratio lies within its limits, which blur a little."""
    excess = max(limits[0] - ratio, ratio - limits[1]) / RATIO_SPREAD
    return -np.inf if excess > 2.0 else -float(np.logaddexp(0.0, 2.0 * excess))


def _named(voxels: Voxels, best: Hypothesis, probability: float) -> Naming:
    stack, ground = _with_thin_body(best.fit.state, voxels), float(best.fit.state.heights[0])
    held = not _is_unseen(best.fit.state, voxels)[0] and not _is_hovering(voxels, ground)
    width = 2.0 * float(stack.widest.max())
    bottom, top = stack.heights[0], stack.heights[-1]
    return Naming(
        label=best.kind.name,
        probability=probability,
        centre=np.array([stack.axis[0], (bottom + top) / 2.0, stack.axis[1]]),
        size=np.array([width, top - bottom, width]),
        parts=_parts(voxels, [part.role for part in best.kind.parts], solids(stack)),
        deviance=best.fit.bic * len(voxels) / len(best.fit.residuals) - _unknown_deviance(voxels),
        is_hovering=len(voxels) < HOVERING_CELLS and not held,
    )


def _with_thin_body(stack: Stack, voxels: Voxels) -> Stack:
    """The stack, its lowest part no wider than a trunk where it is not seen."""
    if not _is_unseen(stack, voxels)[0] or not len(stack.radii[0]):
        return stack
    radius = np.minimum(stack.radii[0], TRUNK * stack.widest[1:].max(initial=0.0))
    return replace(stack, radii=(radius, *stack.radii[1:]))


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
