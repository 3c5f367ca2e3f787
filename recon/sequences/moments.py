"""When each frame of a folder was taken and from where: rows of times.txt and poses.txt."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.sequences.poses import T_up_recorded, Trajectory, read_lines, read_trajectory

Array = NDArray[np.float64]
Poses = Literal["given", "estimated", "none"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """One frame's time and pose."""

    stamp_s: float
    T_world_left: Array | None = None
    """(4, 4) of the left camera as it is, in recon's world."""
    fault: str | None = None
    """Why the frame cannot be used."""


def list_moments(folder: Path, names: Sequence[str], poses: Poses) -> list[Moment]:
    """The moment of each named frame; without times.txt the number of its row is its time.

    As many rows as names go in order. Otherwise names that are numbers count from frame 0 in the
    first row, so that a frame that is missing on both sides does not shift the rest.

    Raises
    ------
    InputError
        Where poses are to be given and are not.
    """
    times = _read_times(folder / "times.txt")
    trajectory = given_trajectory(folder / "poses.txt", len(names)) if poses == "given" else None
    if trajectory is not None and times is None:
        times = trajectory.stamps_s
    num_rows = len(trajectory or times if times is not None else names)
    rows = _rows(names, num_rows)
    return [_moment(row, times, trajectory) for row in rows]


def given_trajectory(path: Path, num_frames: int) -> Trajectory:
    """The poses of a file; a single frame without one stands at the origin."""
    if path.is_file():
        return read_trajectory(path)
    if num_frames == 1:
        return Trajectory(poses=np.eye(4)[None], stamps_s=None)
    raise InputError(
        f"{path} is missing, but {num_frames} frames need poses: give them, or take "
        "--poses estimated or --poses none"
    )


def _rows(names: Sequence[str], num_rows: int) -> list[int]:
    numbered = len(names) != num_rows and all(name.isdigit() for name in names)
    return [int(name) for name in names] if numbered else [*range(len(names))]


def _moment(row: int, times: Array | None, trajectory: Trajectory | None) -> Moment:
    if times is not None and row >= len(times):
        return Moment(stamp_s=float(row), fault=f"times.txt has no row {row + 1} for it")
    stamp = float(row) if times is None else float(times[row])
    if trajectory is None:
        return Moment(stamp_s=stamp)
    timed = trajectory.stamps_s is not None
    T_recorded_left = trajectory.at(stamp if timed else row)
    if T_recorded_left is None:
        return Moment(stamp_s=stamp, fault="poses.txt has no pose for it")
    T_world_recorded = T_up_recorded(trajectory.poses[0])
    return Moment(stamp_s=stamp, T_world_left=T_world_recorded @ T_recorded_left)


def _read_times(path: Path) -> Array | None:
    if not path.is_file():
        return None
    times = []
    for number, line in enumerate(read_lines(path), start=1):
        try:
            times += [float(line.split()[0])] if line.strip() else []
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {line[:40]!r} is no time") from error
    return np.array(times)
