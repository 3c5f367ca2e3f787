"""Learning of kinds from examples: which descriptors distinguish them, and at what distance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.recognition.naming.descriptors import DESCRIPTORS, USUAL_SCALES, Group, Learned, describe
from recon.records import Voxels

Array = NDArray[np.float64]

LEFT_OUT_SHARE = 0.9
"""Share of the left-out examples that the threshold accepts."""
ROOM = 1.3
"""A new example is a little further from the others than these are from each other."""
LEAST = 1.3
"""Minimum threshold, for nearly identical examples: a new one is seen from elsewhere."""
ALONE = 1.8
"""Threshold for a single example, whose variation is unknown, in typical distances: wide, since
accepted objects get no high probability."""
PRIOR_EXAMPLES = 2.0
"""Number of examples that the prior distance counts for."""
TELLS = 1.5
"""A group distinguishes a kind if the examples of other kinds are this many times as far away as
its own; other groups are left out."""
DIGITS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupReport:
    """One group of descriptors, and whether a kind uses it."""

    name: str
    used: bool
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lesson:
    """Description learned from examples."""

    learned: Learned
    groups: tuple[GroupReport, ...]
    num_examples: int


def learn(
    name: str, examples: Sequence[Voxels], others: Mapping[str, Learned], unit: str | None = None
) -> Lesson:
    """Learn a kind from examples.

    Parameters
    ----------
    examples : sequence of Voxels
        The cells of one object per example, y up.
    others : mapping of str to Learned
        Kinds of the same catalogue, from which it must be distinguishable.
    unit : str, optional
        Unit of the examples' lengths, if known.

    Raises
    ------
    InputError
        If there is no example, or the kind cannot be distinguished from another.
    """
    if not examples:
        raise InputError("there is no example, but at least one is needed to learn a kind")
    rows = _rows([describe(voxels) for voxels in examples])
    reports = [_judged(group, rows[group], others) for group in DESCRIPTORS]
    used = [report.name for report in reports if report.used]
    if not used:
        used = [max(DESCRIPTORS, key=lambda group: _lead(group, rows[group], others))]
        reports = [
            GroupReport(name=one.name, used=one.name in used, reason=one.reason) for one in reports
        ]
    learned = _learned({group: rows[group] for group in used}, unit)
    for other, kind in others.items():
        _check_told(name, learned, rows, other, kind)
    return Lesson(learned=learned, groups=tuple(reports), num_examples=len(examples))


def _rows(described: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Descriptors (N, D) of every group."""
    return {name: np.stack([one[name] for one in described]) for name in DESCRIPTORS}


def _distances(rows: Array) -> Array:
    """Distances (N, N) between examples; infinite on the diagonal."""
    apart: Array = np.linalg.norm(rows[:, None] - rows[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    return apart


def _scale(name: str, rows: Array) -> float:
    """Typical distance of two examples, from these examples and the prior."""
    usual = USUAL_SCALES[name]
    if len(rows) < 2:
        return usual
    own = float(np.median(_distances(rows).min(axis=1)))
    return (PRIOR_EXAMPLES * usual + len(rows) * own) / (PRIOR_EXAMPLES + len(rows))


def _lead(name: str, rows: Array, others: Mapping[str, Learned]) -> float:
    """Distance to the nearest example of another kind, in typical distances of this kind."""
    foreign = [
        np.array(kind.groups[name].examples) for kind in others.values() if name in kind.groups
    ]
    if not foreign:
        return np.inf
    apart = np.linalg.norm(rows[:, None] - np.concatenate(foreign)[None], axis=2)
    return float(np.median(apart.min(axis=1))) / _scale(name, rows)


def _judged(name: str, rows: Array, others: Mapping[str, Learned]) -> GroupReport:
    lead = _lead(name, rows, others)
    if np.isinf(lead):
        return GroupReport(name=name, used=True, reason="nothing to tell it from yet")
    reason = f"other kinds are {lead:.1f} times as far away as its own examples"
    return GroupReport(name=name, used=lead >= TELLS, reason=reason)


def _learned(rows: Mapping[str, Array], unit: str | None) -> Learned:
    groups = {
        name: Group(
            scale=round(_scale(name, own), DIGITS),
            examples=tuple(tuple(np.round(row, DIGITS).tolist()) for row in own),
        )
        for name, own in rows.items()
    }
    return Learned(threshold=round(_threshold(rows), DIGITS), groups=groups, unit=unit)


def _threshold(rows: Mapping[str, Array]) -> float:
    """Distance within which most left-out examples are from the others."""
    if len(next(iter(rows.values()))) < 2:
        return ALONE
    squares = [(_distances(own) / _scale(name, own)) ** 2 for name, own in rows.items()]
    left_out = np.sqrt(np.mean(squares, axis=0).min(axis=1))
    return max(ROOM * float(np.quantile(left_out, LEFT_OUT_SHARE)), LEAST)


def _check_told(
    name: str, learned: Learned, rows: Mapping[str, Array], other: str, kind: Learned
) -> None:
    """Reject two kinds that each accept most examples of the other."""
    count = len(next(iter(rows.values())))
    own = [{group: rows[group][i] for group in rows} for i in range(count)]
    shared = [group for group in learned.groups if group in kind.groups]
    if not shared:
        return
    foreign = [
        {group: np.array(kind.groups[group].examples[i]) for group in shared}
        for i in range(len(kind.groups[shared[0]].examples))
    ]
    reduced = Learned(
        threshold=learned.threshold, groups={group: learned.groups[group] for group in shared}
    )
    taken = np.mean([kind.distance(one) <= kind.threshold for one in own])
    taking = np.mean([reduced.distance(one) <= learned.threshold for one in foreign])
    if taken > 0.5 and taking > 0.5:
        raise InputError(
            f"{name} cannot be distinguished from {other}: each accepts most examples of the other "
            f"({taken:.0%}, {taking:.0%}); other examples, or one name for both, are needed"
        )
