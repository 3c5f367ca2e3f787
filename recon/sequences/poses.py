"""Given poses, interpolated in time and transformed to recon's world."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from recon.errors import InputError
from recon.geometry import pose
from recon.records.trajectory import MAX_NUMBER

Array = NDArray[np.float64]

MAX_GAP_S = 0.5
"""Maximum time between two poses for interpolation."""
SAME_TIME_S = 1e-6
END_TOLERANCE_S = 2e-3
"""Tolerance before the first pose and after the last one, for stamps rounded to milliseconds."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GivenPoses:
    """Poses of one moving frame (a camera, a body) in the world of the recording."""

    poses: Array
    """(N, 4, 4) T_recorded_body."""
    stamps_s: Array | None = None
    """(N,) ascending; None if rows are numbered or named, not timed."""
    names: tuple[str, ...] | None = None
    """(N,) image files, if the file states them (COLMAP, nerfstudio)."""
    numbers: NDArray[np.int64] | None = None
    """(N,) frame numbers, if the rows state them (KITTI-360)."""

    def __post_init__(self) -> None:
        if not (np.abs(self.poses) < MAX_NUMBER).all():
            raise InputError(f"a pose contains a number beyond {MAX_NUMBER:g}")

    def __len__(self) -> int:
        return len(self.poses)

    def of(self, T_body_part: Array) -> "GivenPoses":
        """The poses of a part fixed to the body."""
        return replace(self, poses=self.poses @ T_body_part)

    def in_world(self, stamp_s: float) -> Array | None:
        """The pose at a time in recon's world, y up (`T_up_recorded`); None outside."""
        T_recorded_body = self.at(stamp_s)
        return None if T_recorded_body is None else self.T_world_recorded @ T_recorded_body

    def row_in_world(self, row: int) -> Array:
        """The pose of a row in recon's world, y up."""
        T_world_body: Array = self.T_world_recorded @ self.poses[row]
        return T_world_body

    @property
    def T_world_recorded(self) -> Array:
        """(4, 4) rotation from the recording's world to one with y up."""
        return T_up_recorded(self.poses[0])

    def at(self, stamp_s: float) -> Array | None:
        """The pose at a time, interpolated between its neighbours; None outside the time range."""
        stamps = np.arange(len(self)) if self.stamps_s is None else self.stamps_s
        after = int(np.searchsorted(stamps, stamp_s - SAME_TIME_S))
        nearest = int(np.clip(after, 0, len(self) - 1))
        is_end = after in (0, len(self))
        if abs(stamps[nearest] - stamp_s) <= (END_TOLERANCE_S if is_end else SAME_TIME_S):
            exact: Array = self.poses[nearest]
            return exact
        if is_end or stamps[after] - stamps[after - 1] > MAX_GAP_S:
            return None
        share = (stamp_s - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        return _between(self.poses[after - 1], self.poses[after], share)


def _between(first: Array, second: Array, share: float) -> Array:
    turns = Rotation.from_matrix(np.stack([first[:3, :3], second[:3, :3]]))
    position = (1 - share) * first[:3, 3] + share * second[:3, 3]
    return pose(Slerp([0.0, 1.0], turns)(share).as_matrix(), position)


def T_up_recorded(T_recorded_first: ArrayLike) -> Array:
    """The rotation (4, 4) from a recording's world to one with y up.

    A recording's world has its own vertical: KITTI's is the first camera's -y, EuRoC's is z. The
    axis nearest to the first camera's up becomes y, by right angles only, so that a gravity-aligned
    world stays aligned; y up is unchanged. The origin stays.
    """
    up = -np.asarray(T_recorded_first, dtype=np.float64)[:3, 1]
    axis = int(np.argmax(np.abs(up)))
    y = np.sign(up[axis]) * np.eye(3)[axis]
    x = np.eye(3)[1 if axis == 0 else 0]
    return pose(np.stack([x, y, np.cross(x, y)]), np.zeros(3))
