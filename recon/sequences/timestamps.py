"""When each frame was taken and from where: which row of times and poses belongs to it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_finite
from recon.sequences.poses import Trajectory, read_lines

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """One frame's time and pose."""

    stamp_s: float
    T_world_left: Array | None = None
    """(4, 4) of the left camera as it is, in recon's world."""
    fault: str | None = None
    """Why the frame cannot be used."""


def list_moments(
    names: Sequence[str],
    times: Array | None,
    trajectory: Trajectory | None,
    *,
    needs_pose: bool = True,
) -> list[Moment]:
    """The moment of each named frame; where nothing is timed, the number of its row is its time.

    Rows that are as many as names go in order. Otherwise the numbers in the names count the rows,
    so that a frame that is missing does not shift the rest: from the first frame where the
    numbers span as many rows as there are, else from frame 0.

    Parameters
    ----------
    names : sequence of str
    times : (R,) or None
        Seconds, one a row.
    trajectory : Trajectory or None
        Of the left camera, timed or one pose a row.
    needs_pose : bool
        Whether a frame for which the trajectory has no pose is at fault.

    Raises
    ------
    InputError
        Where there are more rows than frames and the names have no numbers.
    """
    if trajectory is not None and times is None:
        times = trajectory.stamps_s
    num_rows = next((len(rows) for rows in (times, trajectory) if rows is not None), len(names))
    return [_moment(row, times, trajectory, needs_pose) for row in _rows(names, num_rows)]


def _rows(names: Sequence[str], num_rows: int) -> list[int]:
    numbers = [last_number(name) for name in names]
    if len(names) == num_rows:
        return [*range(num_rows)]
    if None in numbers and len(names) < num_rows:
        raise InputError(
            f"there are {num_rows} times or poses for {len(names)} frames, whose names "
            f"({names[0]}, ...) have no numbers to tell which is whose"
        )
    known = [number if number is not None else row for row, number in enumerate(numbers)]
    start = known[0] if known[-1] - known[0] + 1 == num_rows else 0
    return [number - start for number in known]


def last_number(name: str) -> int | None:
    """The last whole number in a name, None where there is none."""
    numbers = re.findall(r"\d+", name)
    return int(numbers[-1]) if numbers else None


def _moment(
    row: int, times: Array | None, trajectory: Trajectory | None, needs_pose: bool
) -> Moment:
    if times is not None and row >= len(times):
        return Moment(stamp_s=float(row), fault=f"there is no time in row {row + 1} for it")
    stamp = float(row) if times is None else float(times[row])
    if trajectory is None:
        return Moment(stamp_s=stamp)
    T_world_left = trajectory.in_world(float(row) if trajectory.stamps_s is None else stamp)
    fault = "there is no pose for it" if needs_pose and T_world_left is None else None
    return Moment(stamp_s=stamp, T_world_left=T_world_left, fault=fault)


def read_times(path: Path) -> Array | None:
    """The first number of each line of a file, seconds; None where there is no file.

    Raises
    ------
    InputError
        With the line that has none.
    """
    if not path.is_file():
        return None
    times: list[float] = []
    for number, line in enumerate(read_lines(path), start=1):
        try:
            times += [float(line.split()[0])] if line.strip() else []
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {line[:40]!r} is no time") from error
    check_finite(str(path), np.array(times))
    return np.array(times)
