"""Rotations that a file's digits have rounded, made rigid again."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.notices import notify

Array = NDArray[np.float64]

MAX_ROTATION_ERROR = 1e-2
"""Of R R^T: the error that three digits leave."""
EXACT = 1e-12
"""The error that all digits of a float leave: nothing to mend."""
SAID_FROM = 1e-6
"""Six digits leave less; nobody needs to be told of it."""


def rigid(name: str, T: Array) -> Array:
    """The motion `T` (4, 4) with its rotation made exact; one that was far from it is said.

    Raises
    ------
    InputError
        Where it is further from a rotation than rounding explains.
    """
    exact, error = made_rigid(name, T)
    say_rigid(name, error)
    return exact


def made_rigid(name: str, T: Array) -> tuple[Array, float]:
    """The motion with its rotation made exact, and how far R R^T was from the identity."""
    rotation = T[:3, :3]
    # Huge numbers overflow, and are then off by infinity.
    with np.errstate(over="ignore", invalid="ignore"):
        error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if not error <= MAX_ROTATION_ERROR or np.linalg.det(rotation) < 0:
        raise InputError(f"{name} is not a rotation and step (R R^T is off by {error:.2g})")
    if error < EXACT:
        return pose(rotation, T[:3, 3]), error
    return pose(Rotation.from_matrix(rotation).as_matrix(), T[:3, 3]), error


def say_rigid(name: str, error: float) -> None:
    """Tell of a rotation that was off by more than the usual digits leave."""
    if error > SAID_FROM:
        notify(
            "rotation-made-rigid",
            f"{name} is not quite a rotation (R R^T is off by {error:.1g}): the nearest is used",
        )
