"""The residual of a rectification from the images alone, selected on held-out images."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.sequences.calibration.row_error import NUM_TERMS, Field, Residual, terms
from recon.sequences.odometry.motion import (
    DAMPING,
    agreeing_tracks,
    are_near,
    estimate_motion,
    linearise,
    motion_changed,
    refine_motion,
)
from recon.sequences.odometry.tracking import Sightings, Tracks

Array = NDArray[np.float64]
Seen = TypeVar("Seen", Sightings, Tracks)

FIELDS = ([0], [0, 3], [0, 1, 2, 3, 4, 5])
"""Terms of the candidate fields besides none, increasingly rich: constant; the effect of a relative
rotation of the cameras, 1 and x^2; a full quadratic."""
MIN_GAIN = 0.02
"""Relative decrease of the held-out cost required of a richer field: each term makes the scale less
certain."""
MIN_CALIBRATION_TRACKS = 1000
"""Over all pairs; fewer lie on few objects, whose sliding silhouettes resemble a residual."""
NUM_PASSES, NUM_ROUNDS = 2, 10
SMALL_STEP_PX = 1e-3
PRIOR_PX = 3.0
"""Prior standard deviation of a coefficient: a rig at rest is uninformative."""
ROW_SIGMA_PX = 0.15
"""Standard deviation of the row offset of one corner."""


def estimate_residual(tracks: Sequence[Tracks], rig: StereoRig) -> Residual:
    """Residuals of rows and disparities, from the tracks between pairs of one rig.

    A field is fitted to every other pair of pairs and evaluated by its robust cost on the rest; the
    best is then fitted to all.
    """
    row = estimate_row_residual([seen.first for seen in tracks], rig).row
    return Residual(row=row, disparity=_chosen(tracks, rig, _fit_disparity, _disparity_cost))


@dataclass(frozen=True, slots=True, kw_only=True)
class Offset:
    """One offset of all disparities, and the share of the robust cost that it saves."""

    offset_px: float
    gain: float


def fitted_offset(tracks: Sequence[Tracks], rig: StereoRig) -> Offset:
    """The offset with which the tracks between pairs of one rig agree best on its motions."""
    field = _fit_disparity(tracks, rig, [0])
    before = _disparity_cost(tracks, rig, Field())
    gain = 1.0 - _disparity_cost(tracks, rig, field) / before if before > 0 else 0.0
    return Offset(offset_px=float(field.coefficients[0]), gain=gain)


def estimate_row_residual(seen: Sequence[Sightings], rig: StereoRig) -> Residual:
    """Residuals of rows from single pairs of one rig, without disparities."""
    return Residual(row=_chosen(seen, rig, _fit_row, _row_cost))


def _chosen(
    data: Sequence[Seen],
    rig: StereoRig,
    fit: Callable[[Sequence[Seen], StereoRig, list[int]], Field],
    cost: Callable[[Sequence[Seen], StereoRig, Field], float],
) -> Field:
    fitted, held_out = data[::2], data[1::2]
    if sum(len(seen) for seen in data) < MIN_CALIBRATION_TRACKS or not held_out:
        return Field()
    best, least = None, cost(held_out, rig, Field())
    for used in FIELDS:
        now = cost(held_out, rig, fit(fitted, rig, used))
        if now < (1.0 - MIN_GAIN) * least:
            best, least = used, now
    return fit(data, rig, best) if best else Field()


def _field(used: list[int], values: Array) -> Field:
    """The field with values for some terms."""
    coefficients = np.zeros(NUM_TERMS)
    coefficients[used] = values
    return Field(coefficients=coefficients)


def _fit_row(seen: Sequence[Sightings], rig: StereoRig, used: list[int]) -> Field:
    points = np.concatenate([s.right_points_px for s in seen])
    offset = np.concatenate([s.row_offset_px for s in seen])
    design = terms(points, rig)[:, used]
    coefficients = np.zeros(len(used))
    for _ in range(NUM_ROUNDS):
        error = (offset - design @ coefficients) / ROW_SIGMA_PX
        weight = np.sqrt(1.0 / (1.0 + error**2))
        coefficients = np.linalg.lstsq(design * weight[:, None], offset * weight, rcond=None)[0]
    return _field(used, coefficients)


def _row_cost(seen: Sequence[Sightings], rig: StereoRig, row: Field) -> float:
    offsets = [s.row_offset_px - row.at(s.right_points_px, rig) for s in seen]
    return float(np.log1p((np.concatenate(offsets) / ROW_SIGMA_PX) ** 2).sum())


def _disparity_cost(tracks: Sequence[Tracks], rig: StereoRig, disparity: Field) -> float:
    """Mean robust cost of the tracks between two pairs under one motion, including outliers."""
    costs = [np.zeros(0)]
    for seen in tracks:
        corrected = Residual(disparity=disparity).corrected(seen, rig)
        motion = estimate_motion(corrected, rig)
        if motion is not None:
            near = corrected.select(are_near(corrected, rig))
            costs.append(linearise(motion, near, rig).costs)
    every = np.concatenate(costs)
    return float(every.mean()) if every.size else 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Motion:
    """A motion and the measured tracks that agree on it."""

    T_second_first: Array
    tracks: Tracks


def _fit_disparity(tracks: Sequence[Tracks], rig: StereoRig, used: list[int]) -> Field:
    """Estimate all motions and the field jointly: Gauss-Newton with the motions eliminated."""
    field = Field()
    for _ in range(NUM_PASSES):
        starts = (_start(seen, rig, field) for seen in tracks)
        motions = [motion for motion in starts if motion is not None]
        for _ in range(NUM_ROUNDS if motions else 0):
            change, motions = _step(motions, rig, field, used)
            field = Field(coefficients=field.coefficients + _field(used, change).coefficients)
            if np.abs(change).max() < SMALL_STEP_PX:
                break
    return field


def _start(seen: Tracks, rig: StereoRig, disparity: Field) -> _Motion | None:
    corrected = Residual(disparity=disparity).corrected(seen, rig)
    agreeing = agreeing_tracks(corrected, rig)
    if agreeing is None:
        return None
    T_second_first, rows = agreeing
    refined = refine_motion(T_second_first, corrected.select(rows), rig)
    return refined if refined is None else _Motion(T_second_first=refined, tracks=seen.select(rows))


def _step(
    motions: Sequence[_Motion], rig: StereoRig, field: Field, used: list[int]
) -> tuple[Array, list[_Motion]]:
    """The update of the used terms (K,), and the motions updated with it."""
    blocks = [_block(motion, rig, field, used) for motion in motions]
    prior = 1.0 / PRIOR_PX**2
    normal = np.sum([block.normal for block in blocks], axis=0) + prior * np.eye(len(used))
    gradient = np.sum([block.gradient for block in blocks], axis=0)
    gradient += prior * field.coefficients[used]
    change: Array = -np.linalg.solve(normal, gradient)
    return change, [
        replace(
            motion,
            T_second_first=motion_changed(motion.T_second_first, block.motion_change(change)),
        )
        for motion, block in zip(motions, blocks, strict=True)
    ]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Block:
    """Normal equations of the field, one motion eliminated (Schur complement)."""

    normal: Array
    """(K, K)"""
    gradient: Array
    """(K,)"""
    back: Array
    """(6, K + 1) back substitution from the field's change and 1 to the motion, negative."""

    def motion_change(self, change: Array) -> Array:
        """(6,) rotation and translation update for a change of the field (K,)."""
        moved_by: Array = -self.back @ np.append(change, 1.0)
        return moved_by


def _block(motion: _Motion, rig: StereoRig, field: Field, used: list[int]) -> _Block:
    corrected = Residual(disparity=field).corrected(motion.tracks, rig)
    at = linearise(motion.T_second_first, corrected, rig)
    by_field = sum(
        at.by_shift[:, :, eye, None] * terms(seen.right_points_px, rig)[:, None, used]
        for eye, seen in enumerate((motion.tracks.first, motion.tracks.second))
    )
    both = np.concatenate([at.by_motion, by_field, at.residual[:, :, None]], axis=2)
    product = np.einsum("n,nij,nik->jk", at.weights, both, both, optimize=True)
    by_motion = product[:6, :6] + DAMPING * np.trace(product[:6, :6]) * np.eye(6)
    back = np.linalg.solve(by_motion, product[:6, 6:])
    reduced = product[6:, 6:] - product[6:, :6] @ back
    return _Block(normal=reduced[:-1, :-1], gradient=reduced[:-1, -1], back=back)
