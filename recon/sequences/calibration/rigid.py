"""Rotations rounded by the digits of a file, made orthonormal again."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.notices import notify

Array = NDArray[np.float64]

MAX_ROTATION_ERROR = 1e-2
"""Maximum error of R R^T: that of three digits."""
EXACT = 1e-12
"""Error of a full-precision rotation, which needs no correction."""
SAID_FROM = 1e-6
"""Error above which a notice is given; six digits cause less."""


def rigid(name: str, T: Array) -> Array:
    """The motion `T` (4, 4) with its rotation made exact; a large correction causes a notice.

    Raises
    ------
    InputError
        If it is further from a rotation than rounding can explain.
    """
    exact, error = made_rigid(name, T)
    say_rigid(name, error)
    return exact


def made_rigid(name: str, T: Array) -> tuple[Array, float]:
    """The motion with its rotation made exact, and the deviation of R R^T from the identity."""
    rotation = T[:3, :3]
    # Huge numbers overflow to an infinite error.
    with np.errstate(over="ignore", invalid="ignore"):
        error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if not error <= MAX_ROTATION_ERROR or np.linalg.det(rotation) < 0:
        fault = "it mirrors" if error <= MAX_ROTATION_ERROR else f"R R^T is off by {error:.2g}"
        raise InputError(f"{name} is not a rotation and translation ({fault})")
    if error < EXACT:
        return pose(rotation, T[:3, 3]), error
    return pose(Rotation.from_matrix(rotation).as_matrix(), T[:3, 3]), error


def say_rigid(name: str, error: float) -> None:
    """Notify of a rotation that was off by more than the usual rounding."""
    if error > SAID_FROM:
        notify(
            "rotation-made-rigid",
            f"{name} is not quite a rotation (R R^T is off by {error:.1g}): the nearest is used",
        )
