"""Given poses: read through evo, told apart by content, brought into recon's world."""

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from recon.errors import InputError
from recon.geometry import pose

Array = NDArray[np.float64]

MAX_GAP_S = 0.5
"""Between two poses further apart nothing is interpolated."""
MAX_ROTATION_ERROR = 1e-2
"""Of R R^T: what three digits leave."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """Poses of one moving frame (a camera, a body) in the world of the recording."""

    poses: Array
    """(N, 4, 4) T_recorded_body."""
    stamps_s: Array | None
    """(N,) rising; None where rows are numbered, not timed (KITTI)."""

    def __len__(self) -> int:
        return len(self.poses)

    def of(self, T_body_part: Array) -> "Trajectory":
        """The poses of a part that is fixed to the body."""
        return Trajectory(poses=self.poses @ T_body_part, stamps_s=self.stamps_s)

    def in_world(self, stamp_s: float) -> Array | None:
        """The pose at a time in recon's world, y up (`T_up_recorded`); None outside."""
        T_recorded_body = self.at(stamp_s)
        if T_recorded_body is None:
            return None
        return T_up_recorded(self.poses[0]) @ T_recorded_body

    def at(self, stamp_s: float) -> Array | None:
        """The pose at a time, moved and turned evenly between its neighbours; None outside."""
        stamps = np.arange(len(self)) if self.stamps_s is None else self.stamps_s
        after = int(np.searchsorted(stamps, stamp_s - 1e-6))
        if after == len(self):
            return None
        if abs(stamps[after] - stamp_s) <= 1e-6:
            exact: Array = self.poses[after]
            return exact
        if after == 0 or stamps[after] - stamps[after - 1] > MAX_GAP_S:
            return None
        share = (stamp_s - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        return _between(self.poses[after - 1], self.poses[after], share)


def _between(first: Array, second: Array, share: float) -> Array:
    turns = Rotation.from_matrix(np.stack([first[:3, :3], second[:3, :3]]))
    position = (1 - share) * first[:3, 3] + share * second[:3, 3]
    return pose(Slerp([0.0, 1.0], turns)(share).as_matrix(), position)


def read_trajectory(path: Path) -> Trajectory:
    """Poses in KITTI's form (12 numbers a row), TUM's (8) or EuRoC's (8 and more, with commas).

    Raises
    ------
    InputError
        With the line that is no pose, or whose time goes back.
    """
    from evo.tools import file_interface

    lines, rows, has_commas = _number_rows(path)
    columns = {len(row) for row in rows}
    if has_commas and min(columns) >= 8:
        recorded = file_interface.read_euroc_csv_trajectory(_text(rows, ","))
    elif columns == {8}:
        recorded = file_interface.read_tum_trajectory_file(_text(rows, " "))
    elif columns == {12}:
        recorded = file_interface.read_kitti_poses_file(_text(rows, " "))
    else:
        odd = next((n for n, row in zip(lines, rows, strict=True) if len(row) not in (8, 12)), 1)
        raise InputError(
            f"{path}, line {odd}: rows have {sorted(columns)} numbers, but 12 (KITTI), 8 (TUM) "
            "or EuRoC's with commas are needed"
        )
    stamps = getattr(recorded, "timestamps", None)
    if stamps is not None and (np.diff(stamps) <= 0).any():
        raise InputError(
            f"{path}, line {lines[int(np.argmax(np.diff(stamps) <= 0)) + 1]}: the time is not "
            "after the one before"
        )
    poses = [
        exact(f"{path}, line {line}: the pose", T)
        for line, T in zip(lines, recorded.poses_se3, strict=True)
    ]
    return Trajectory(poses=np.stack(poses), stamps_s=stamps)


def _number_rows(path: Path) -> tuple[list[int], list[list[str]], bool]:
    """Line numbers, fields, and whether commas part them."""
    lines, rows, has_commas = [], [], False
    for number, line in enumerate(read_lines(path), start=1):
        bare = line.partition("#")[0].strip().rstrip(",")
        if not bare:
            continue
        has_commas = has_commas or "," in bare
        lines.append(number)
        rows.append(bare.replace(",", " ").split())
        if not all(_is_finite(field) for field in rows[-1]):
            raise InputError(f"{path}, line {number}: {bare[:60]!r}, but finite numbers are needed")
    if not rows:
        raise InputError(f"{path} holds no pose")
    return lines, rows, has_commas


def read_lines(path: Path) -> list[str]:
    """The lines of a text file.

    Raises
    ------
    InputError
        Where it cannot be read or is no text.
    """
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise InputError(f"{path} cannot be read ({reason})") from error


def _is_finite(field: str) -> bool:
    try:
        return bool(np.isfinite(float(field)))
    except ValueError:
        return False


def _text(rows: list[list[str]], separator: str) -> io.StringIO:
    return io.StringIO("\n".join(separator.join(row) for row in rows))


def exact(name: str, T: Array) -> Array:
    """The motion `T` (4, 4) with its rotation, rounded by a file's digits, made exact.

    Raises
    ------
    InputError
        Where it is further from a rotation than rounding explains.
    """
    rotation = T[:3, :3]
    error = np.abs(rotation @ rotation.T - np.eye(3)).max()
    if not error <= MAX_ROTATION_ERROR or np.linalg.det(rotation) < 0:
        raise InputError(f"{name} is no rotation and step (R R^T is off by {error:.2g})")
    return pose(Rotation.from_matrix(rotation).as_matrix(), T[:3, 3])


def T_up_recorded(T_recorded_first: ArrayLike) -> Array:
    """The turn (4, 4) that makes a recording's world one with y up.

    A recording's world has its own vertical: KITTI's is the first camera's -y, EuRoC's is z. The
    axis nearest to the first camera's up becomes y, by right angles only, so that a world that
    knows gravity keeps it; y up stays as it is. The origin stays.
    """
    up = -np.asarray(T_recorded_first, dtype=np.float64)[:3, 1]
    axis = int(np.argmax(np.abs(up)))
    y = np.sign(up[axis]) * np.eye(3)[axis]
    x = np.eye(3)[1 if axis == 0 else 0]
    return pose(np.stack([x, y, np.cross(x, y)]), np.zeros(3))
