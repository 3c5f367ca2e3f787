"""Steps of a pose about an object and about its camera."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.geometry import pose, rotation_about_y

Array = NDArray[np.float64]


def turned(T_world_left: Array, centre: Array, degrees: float) -> Array:
    """A pose after a turn about the upright axis through a centre."""
    turn = rotation_about_y(math.radians(degrees))
    return pose(turn, centre - turn @ centre) @ T_world_left


def stepped(T_world_left: Array, centre: Array, step: Array) -> Array:
    """A pose after steps (3,): degrees about an object, about the camera, and a share nearer."""
    near = T_world_left.copy()
    near[:3, 3] += step[2] * (centre - near[:3, 3]) * np.array([1.0, 0.0, 1.0])
    return turned(turned(near, near[:3, 3], step[1]), centre, step[0])


def difference(T_world_left: Array, other: Array) -> Array:
    """Small rotation and shift (6,) that lead from a pose to another."""
    turn = Rotation.from_matrix(other[:3, :3] @ T_world_left[:3, :3].T).as_rotvec()
    return np.concatenate([turn, other[:3, 3] - T_world_left[:3, 3]])
