"""Stance: the height of cameras that stand upright on the ground, and how far up they look."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.geometry import pose, rotation_about_y
from recon.localisation.graph import planar
from recon.localisation.registration import Prior, inverse, moved
from recon.records import PoseEstimate

Array = NDArray[np.float64]

SAME_HEIGHT_CELLS, MAX_ROLL = 0.1, 0.01
"""Maximum difference of heights, and maximum slope of the cameras' rows, of a shared stance."""
PITCH_STEP_DEG, MOST_PITCHES = 5.0, 12
"""Distance, and maximum number, of the pitches that are tried."""
HEIGHT_SIGMA_CELLS, ROLL_SIGMA_DEG = 0.05, 0.1
"""Standard deviations of height and roll of a pair that is taken in the same stance ..."""
PLACE_SIGMA_CELLS, HEADING_SIGMA_DEG, PITCH_SIGMA_DEG = 2.0, 8.0, 2.5
"""... and of its position, heading and pitch, before they are registered."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stance:
    """The height and the pitches that all cameras of a run share."""

    height: float
    """y of the cameras, world units."""
    pitches: tuple[float, ...]
    """Angles between the cameras' axes and the ground that may occur, radians."""

    @classmethod
    def of(cls, T_world_left: Array, cell_size: float) -> "Stance | None":
        """The stance of poses (N, 4, 4); None if they do not share one."""
        if not len(T_world_left):
            return None
        heights = T_world_left[:, 1, 3]
        degrees = np.degrees(np.arcsin(np.clip(T_world_left[:, 1, 2], -1.0, 1.0)))
        steps = np.unique(np.round(degrees / PITCH_STEP_DEG))
        is_shared = (
            np.ptp(heights) < SAME_HEIGHT_CELLS * cell_size
            and np.abs(T_world_left[:, 1, 0]).max() < MAX_ROLL
            and len(steps) <= MOST_PITCHES
        )
        pitches = tuple(math.radians(step * PITCH_STEP_DEG) for step in steps.tolist())
        return cls(height=float(np.median(heights)), pitches=pitches) if is_shared else None

    def at(self, place: Array, pitch: float) -> Array:
        """`T_world_left` (4, 4) at x, z and the azimuth of straight ahead (3,)."""
        x, z, azimuth = (float(value) for value in place)
        return pose(rotation_about_y(-azimuth) @ tilt_by(pitch), [x, self.height, z])

    def prior(self, T_world_left: Array, cell_size: float) -> Prior:
        """A pose in this stance whose position, heading and pitch are hardly known."""
        turn = rotation_about_y(-float(planar(T_world_left)[2]))
        own = np.radians([ROLL_SIGMA_DEG, HEADING_SIGMA_DEG, PITCH_SIGMA_DEG])
        cells = np.array([PLACE_SIGMA_CELLS, HEIGHT_SIGMA_CELLS, PLACE_SIGMA_CELLS])
        information = np.diag(np.concatenate([own, cell_size * cells]) ** -2.0)
        information[:3, :3] = turn @ information[:3, :3] @ turn.T
        return Prior(T_world_left=T_world_left, information=information)

    def upright(self, estimate: PoseEstimate, cell_size: float) -> PoseEstimate:
        """A pose corrected by the height of the stance; cameras do not roll."""
        T_world_left = estimate.T_world_left
        pitch = math.asin(float(np.clip(T_world_left[1, 2], -1.0, 1.0)))
        level = self.prior(self.at(planar(T_world_left), pitch), cell_size)
        covariance = inverse(inverse(estimate.covariance) + level.information)
        change = -covariance @ level.information @ level.pull(T_world_left)
        return replace(estimate, T_world_left=moved(T_world_left, change), covariance=covariance)


def tilt_by(pitch: float) -> Array:
    """(3, 3) rotation from a camera that looks up by an angle to the level frame, x ahead."""
    c, s = math.cos(pitch), math.sin(pitch)
    return np.array([[0.0, s, c], [0.0, -c, s], [1.0, 0.0, 0.0]])


def tilt_of(T_world_left: Array) -> Array:
    """(3, 3) rotation from the left camera to the level frame, whose x axis is straight ahead."""
    tilt: Array = rotation_about_y(float(planar(T_world_left)[2])) @ T_world_left[:3, :3]
    return tilt
