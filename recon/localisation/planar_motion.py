"""The planar motion between two pairs of level cameras, from common points.

All disparities of a pair share an error, which turns far points into a wrong distance. It is
estimated together with the motion, so that the covariance states how little far points determine.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import invert, pose, rotation_about_y
from recon.sequences.odometry.motion import MEDIAN_DISTANCE, linearise
from recon.sequences.odometry.tracking import Tracks

Array = NDArray[np.float64]

COMMON_PX = 0.03
"""Standard deviation of the common error of all disparities of a pair."""
NUM_ROUNDS = 10
SMALL_CHANGE = 1e-7
MAX_CONDITION = 1e10
"""Of the equations of a determined motion."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarMotion:
    """The pose of the second pair in the levelled frame of the first."""

    place: Array
    """(3,) x, z and azimuth."""
    covariance: Array
    """(3, 3)"""


def standing(place: Array, T_level_left: Array) -> Array:
    """`T_world_left` (4, 4) at x, z and azimuth (3,), with the camera at height 0."""
    x, z, azimuth = (float(value) for value in place)
    return pose(rotation_about_y(-azimuth), [x, 0.0, z]) @ T_level_left


def planar_motion(
    tracks: Tracks, rig: StereoRig, tilts: tuple[Array, Array], guess: Array
) -> PlanarMotion | None:
    """The motion by Gauss-Newton with Cauchy weights; None if the tracks do not determine it.

    Parameters
    ----------
    tracks : Tracks
        Agreeing tracks, as seen by `rig`.
    tilts : ((4, 4), (4, 4))
        `T_level_left` of both cameras.
    guess : (3,) array
        Approximate x, z and azimuth of the second pair in the levelled frame of the first.
    """
    unknown = np.append(guess, [0.0, 0.0])
    for _ in range(NUM_ROUNDS):
        information, gradient, spread = _equations(unknown, tracks, rig, tilts)
        if not np.linalg.cond(information) < MAX_CONDITION:
            return None
        change = np.linalg.solve(information, -gradient)
        unknown = unknown + change
        if np.abs(change).max() < SMALL_CHANGE:
            break
    covariance = np.asarray(np.linalg.inv(information), np.float64)[:3, :3] * spread**2
    return PlanarMotion(place=unknown[:3], covariance=covariance)


def _equations(
    unknown: Array, tracks: Tracks, rig: StereoRig, tilts: tuple[Array, Array]
) -> tuple[Array, Array, float]:
    """Information (5, 5) and gradient (5,) of motion and common errors, and the spread."""
    first, second = tilts
    place, shift = unknown[:3], unknown[3:]
    at = linearise(invert(standing(place, second)) @ first, tracks, rig)
    residual = at.residual + at.by_shift @ shift
    by_place = at.by_motion @ _by_place(place, second)
    derivative = np.concatenate([by_place, at.by_shift], axis=2)
    distance = np.linalg.norm(residual, axis=1)
    weighted = derivative / (1.0 + distance**2)[:, None, None]
    known = np.diag([0.0, 0.0, 0.0, COMMON_PX**-2.0, COMMON_PX**-2.0])
    information = np.einsum("nij,nik->jk", weighted, derivative) + known
    gradient = np.einsum("nij,ni->j", weighted, residual) + known @ unknown
    return information, gradient, max(1.0, float(np.median(distance)) / MEDIAN_DISTANCE)


def _by_place(place: Array, T_level_left: Array) -> Array:
    """Derivative (6, 3) of the second frame's small motion by its place."""
    to_left = T_level_left[:3, :3].T
    to_level = rotation_about_y(-float(place[2])).T
    derivative = np.zeros((6, 3))
    derivative[3:, :2] = -(to_left @ to_level)[:, [0, 2]]
    derivative[:3, 2] = to_left[:, 1]
    return derivative
