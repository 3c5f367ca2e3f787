"""The trajectory of the left camera, pose by pose."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_shape
from recon.files.rows import rows_of_numbers
from recon.geometry import check_poses, pose

Array = NDArray[np.float64]

MIN_LENGTH = 1e-6
"""Minimum norm of a quaternion; a valid one has norm 1."""
MAX_NUMBER = 1e15
"""Limit for positions and timestamps: squares of larger numbers lose all precision or overflow."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """Poses of the left camera in the world, one per pair, in order."""

    stamps_s: Array
    """(N,)"""
    T_world_left: Array
    """(N, 4, 4)"""

    def __post_init__(self) -> None:
        check_poses("T_world_left", self.T_world_left)
        check_shape("stamps_s", self.stamps_s, (len(self.T_world_left),))

    def __len__(self) -> int:
        return len(self.stamps_s)

    def __repr__(self) -> str:
        return f"Trajectory({len(self)} poses, {self.length:.3g} world units long)"

    @property
    def positions(self) -> Array:
        """(N, 3) in the world."""
        positions: Array = self.T_world_left[:, :3, 3]
        return positions

    @property
    def length(self) -> float:
        """Length of the path from pose to pose, world units."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())

    def as_tum(self) -> str:
        """The text of `trajectory.txt`: stamp tx ty tz qx qy qz qw."""
        # Imported late: every command loads the records, few need this.
        from scipy.spatial.transform import Rotation

        quaternions = Rotation.from_matrix(self.T_world_left[:, :3, :3]).as_quat()
        rows = np.column_stack([self.stamps_s, self.positions, quaternions])
        return "".join(" ".join(f"{value:.9f}" for value in row) + "\n" for row in rows)

    @classmethod
    def from_tum(cls, text: str, name: str = "trajectory") -> Self:
        """Read what `as_tum` wrote.

        Raises
        ------
        InputError
            For a row without eight finite numbers; the message calls the text `name`.
        """
        from scipy.spatial.transform import Rotation

        rows = rows_of_numbers(text, 8, name, "eight numbers")
        if not (np.abs(rows) < MAX_NUMBER).all() or not _turns(rows[:, 4:]).all():
            raise InputError(
                f"{name}: a row does not contain a pose, or has numbers of {MAX_NUMBER:g} or more"
            )
        turns = Rotation.from_quat(rows[:, 4:]).as_matrix() if len(rows) else np.empty((0, 3, 3))
        poses = [pose(*row) for row in zip(turns, rows[:, 1:4], strict=True)]
        return cls(stamps_s=rows[:, 0], T_world_left=np.array(poses).reshape(-1, 4, 4))


def _turns(quaternions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) true for quaternions with a norm that allows normalisation."""
    is_long: NDArray[np.bool_] = np.linalg.norm(quaternions, axis=1) > MIN_LENGTH
    return is_long
