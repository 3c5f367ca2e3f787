"""The planar motion between two pairs of level cameras, from common points.

All disparities of a pair share an error, which turns far points into a wrong distance. It is
estimated together with the motion, so that the covariance states how little far points determine.
The error of a far point's own disparity is the same in both pairs. It does not show in the
residuals, but feigns depth: points that seem to be at several distances and yet move alike tell,
falsely, that the camera has not moved sideways.
What is already known of the motion is known to the estimate: few and far points, which alone
determine no motion, correct what is known. False matches are left out step by step as the motion
gets more precise (graduated non-convexity, Yang et al. 2020).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import invert, pose, rotation_about_y
from recon.localisation.precision import information, shares
from recon.sequences.odometry.motion import (
    MAX_SIGMAS,
    TRACK_SIGMA_PX,
    Linearised,
    linearise,
)
from recon.sequences.odometry.tracking import Tracks

Array = NDArray[np.float64]

COMMON_PX = 0.03
"""Standard deviation of the common error of all disparities of a pair."""
OWN_PX = 0.15
"""Standard deviation of the error of a far disparity that is the same in both pairs; 0.13 to
0.15 against the truth of rendered worlds."""
FAR_PX = 0.15
"""Disparity relative to infinity below which a point may be anywhere."""
GATE = 4.0
"""Standard deviations, of point and known motion, within which a track may be right."""
SCALES = MAX_SIGMAS * 2.0 ** np.arange(4, -1, -1)
"""Residuals, in standard deviations, from which on tracks count little: from round to round."""
NUM_ROUNDS = 4
SMALL_CHANGE = 1e-7
MIN_AGREEING, MIN_SHARE = 5.0, 0.25
"""Minimum number of agreeing points that do not share their errors, and their minimum share of
those that may be right: of many, some agree by chance."""
RIVAL_SHARE = 0.6
"""Share of the agreeing points that another motion may have: texture that repeats has several."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarMotion:
    """The pose of the second pair in the levelled frame of the first."""

    place: Array
    """(3,) x, z and azimuth, with what was known before."""
    information: Array
    """(3, 3) from the points alone."""
    feigned: Array
    """(3, 3) part of it that errors of the points' own depths feign."""
    num_agreeing: float
    """Number of agreeing points; points whose errors are shared count as one."""


def standing(place: Array, T_level_left: Array) -> Array:
    """`T_world_left` (4, 4) at x, z and azimuth (3,), with the camera at height 0."""
    x, z, azimuth = (float(value) for value in place)
    return pose(rotation_about_y(-azimuth), [x, 0.0, z]) @ T_level_left


def planar_motion(
    tracks: Tracks, rig: StereoRig, tilts: tuple[Array, Array], guess: Array, spread: Array
) -> PlanarMotion | None:
    """The motion on which most tracks agree; None if too few do, or others on another one.

    Parameters
    ----------
    tracks : Tracks
        As seen by `rig`; some may be false.
    tilts : ((4, 4), (4, 4))
        `T_level_left` of both cameras.
    guess, spread : (3,), (3, 3) arrays
        x, z and azimuth of the second pair in the levelled frame of the first, as known before,
        and their covariance.
    """
    shift = np.minimum(tracks.first.disparity_px, tracks.second.disparity_px)
    system = _System(tracks.select(shift - rig.disparity_offset_px > FAR_PX), rig, tilts)
    known = _Known.of(guess, spread)
    system = system.select(system.may_be_right(known))
    unknown = system.solved(known)
    agrees = system.agrees(unknown)
    number = system.number(agrees)
    if number < max(MIN_AGREEING, MIN_SHARE * float(system.shares().sum())):
        return None
    others = system.select(~agrees)
    if others.number(others.agrees(others.solved(known))) > RIVAL_SHARE * number:
        return None
    told, feigned = system.select(agrees).of_place(unknown)
    return PlanarMotion(place=unknown[:3], information=told, feigned=feigned, num_agreeing=number)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Known:
    """The prior of place and common errors (5,)."""

    unknown: Array
    information: Array
    """(5, 5)"""

    @classmethod
    def of(cls, guess: Array, spread: Array) -> "_Known":
        information = np.diag([0.0, 0.0, 0.0, COMMON_PX**-2.0, COMMON_PX**-2.0])
        information[:3, :3] = np.linalg.inv(spread)
        return cls(unknown=np.append(guess, [0.0, 0.0]), information=information)


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Tracks as equations of place and common errors (5,)."""

    tracks: Tracks
    rig: StereoRig
    tilts: tuple[Array, Array]

    def select(self, rows: NDArray[np.bool_]) -> "_System":
        """The system of some tracks."""
        return _System(self.tracks.select(rows), self.rig, self.tilts)

    def at(self, unknown: Array) -> tuple[Array, Array]:
        """Whitened residuals (N, 3) and derivatives (N, 3, 5)."""
        first, second = self.tilts
        place, shift = unknown[:3], unknown[3:]
        T_second_first = invert(standing(place, second)) @ first
        at = linearise(T_second_first, self.tracks, self.rig)
        residual = at.residual + at.by_shift @ shift
        # At the depths that both pairs tell: those of the first alone would shorten the motion.
        there = linearise(T_second_first, self._deep(at, residual), self.rig)
        by_place = there.by_motion @ _by_place(place, second)
        return residual, np.concatenate([by_place, there.by_shift], axis=2)

    def _deep(self, at: Linearised, residual: Array) -> Tracks:
        """The tracks with the first disparities that agree best with the second pair."""
        first = self.tracks.first
        off_px = TRACK_SIGMA_PX**2 * (at.by_shift[:, :, 0] * residual).sum(axis=1)
        better = replace(first, disparity_px=np.maximum(first.disparity_px - off_px, self.least_px))
        return replace(self.tracks, first=better)

    def may_be_right(self, known: _Known) -> NDArray[np.bool_]:
        """Mask (N,) of the tracks that what is known allows."""
        residual, derivative = self.at(known.unknown)
        spread = np.linalg.inv(known.information)
        whole = np.eye(3) + derivative @ spread @ derivative.swapaxes(1, 2)
        off = np.linalg.solve(whole, residual[..., None])[..., 0]
        allowed: NDArray[np.bool_] = (residual * off).sum(axis=1) < GATE**2
        return allowed

    def solved(self, known: _Known) -> Array:
        """The unknowns (5,) that agree best with the tracks and with what is known."""
        unknown = known.unknown
        for scale in SCALES:
            for _ in range(NUM_ROUNDS):
                residual, derivative = self.at(unknown)
                weight = self.shares() / (1.0 + (residual**2).sum(axis=1) / scale**2) ** 2
                gradient = np.einsum("n,nij,ni->j", weight, derivative, residual)
                gradient += known.information @ (unknown - known.unknown)
                normal = np.einsum("n,nij,nik->jk", weight, derivative, derivative)
                change = np.linalg.solve(normal + known.information, -gradient)
                unknown = unknown + change
                if np.abs(change).max() < SMALL_CHANGE:
                    break
        return unknown

    def agrees(self, unknown: Array) -> NDArray[np.bool_]:
        """Mask (N,) of the tracks that agree."""
        agrees: NDArray[np.bool_] = np.linalg.norm(self.at(unknown)[0], axis=1) < MAX_SIGMAS
        return agrees

    def shares(self) -> Array:
        """Weights (N,) of the tracks."""
        return shares(self.tracks)

    def number(self, agrees: NDArray[np.bool_]) -> float:
        """Number of agreeing tracks that do not share their errors."""
        return float(self.select(agrees).shares().sum()) if agrees.any() else 0.0

    def of_place(self, unknown: Array) -> tuple[Array, Array]:
        """Information (3, 3) of the place from agreeing tracks, and the feigned part of it."""
        residual, derivative = self.at(unknown)
        normal = information(residual, derivative, self.shares())
        normal[[3, 4], [3, 4]] += COMMON_PX**-2.0
        # Whatever the common errors are.
        by_common = np.linalg.solve(normal[3:, 3:], normal[3:, :3])
        alone: Array = normal[:3, :3] - normal[:3, 3:] @ by_common
        nearer, farther = (self.changed(px).at(unknown)[1] for px in (OWN_PX, -OWN_PX))
        return alone, information(residual, (nearer - farther)[..., :3] / 2.0, self.shares())

    def changed(self, by_px: float) -> "_System":
        """The system with all disparities of both pairs changed."""
        first, second = (
            replace(one, disparity_px=np.maximum(one.disparity_px + by_px, self.least_px))
            for one in (self.tracks.first, self.tracks.second)
        )
        return _System(Tracks(first=first, second=second), self.rig, self.tilts)

    @property
    def least_px(self) -> float:
        """Disparity of the farthest points."""
        return self.rig.disparity_offset_px + FAR_PX


def _by_place(place: Array, T_level_left: Array) -> Array:
    """Derivative (6, 3) of the second frame's small motion by its place."""
    to_left = T_level_left[:3, :3].T
    to_level = rotation_about_y(-float(place[2])).T
    derivative = np.zeros((6, 3))
    derivative[3:, :2] = -(to_left @ to_level)[:, [0, 2]]
    derivative[:3, 2] = to_left[:, 1]
    return derivative
