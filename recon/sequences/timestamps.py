"""Times and poses of frames: assignment of file rows to frames."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_finite
from recon.sequences.poses import GivenPoses
from recon.sequences.text import read_lines
from recon.sequences.units import in_seconds, matched

Array = NDArray[np.float64]

MIN_STAMP = 10**9
"""Larger numbers in names are times: in nanoseconds a second, in seconds the year 2001."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FramePose:
    """One frame's time and pose."""

    stamp_s: float
    T_world_left: Array | None = None
    """(4, 4) of the raw left camera, in recon's world."""
    fault: str | None = None
    """The reason why the frame cannot be used."""


def list_frame_poses(
    names: Sequence[str],
    times: Array | None,
    given: GivenPoses | None,
    *,
    needs_pose: bool = True,
) -> list[FramePose]:
    """The time and pose of each named frame.

    Without times, the row number is the time. If there are as many rows as names, they correspond
    in order. Otherwise the numbers in the names index the rows, so that a missing frame does not
    shift the rest: relative to the first frame if the numbers span all rows, else to frame 0. Poses
    with times are assigned by time if the frames have times, too, in a file or as their names.

    Parameters
    ----------
    names : sequence of str
    times : (R,) or None
        Seconds, one per row.
    given : GivenPoses or None
        Poses of the left camera: timed, named, numbered, or one per row.
    needs_pose : bool
        True if a frame without a pose is unusable; otherwise poses that cannot be assigned are
        ignored.

    Raises
    ------
    InputError
        If times or poses match the frames neither in number nor by the names.
    """
    if times is None and given is not None and given.stamps_s is not None:
        times = _times_of_names(names, given)
    stamps = _stamps(names, times, given)
    if given is None:
        return [FramePose(stamp_s=stamp) for stamp in stamps]
    try:
        poses = _poses(names, stamps, given, is_timed=times is not None)
    except InputError:
        if needs_pose:
            raise
        return [FramePose(stamp_s=stamp) for stamp in stamps]
    return [
        FramePose(
            stamp_s=stamp,
            T_world_left=T,
            fault="there is no pose for it" if needs_pose and T is None else None,
        )
        for stamp, T in zip(stamps, poses, strict=True)
    ]


def _times_of_names(names: Sequence[str], given: GivenPoses) -> Array | None:
    """Times in seconds from the frame names, as in EuRoC; None if they have none."""
    assert given.stamps_s is not None
    numbers = [last_number(name) for name in names]
    if any(number is None or number < MIN_STAMP for number in numbers):
        return None
    return in_seconds(np.array(numbers, dtype=np.float64))


def _stamps(names: Sequence[str], times: Array | None, given: GivenPoses | None) -> list[float]:
    if times is not None:
        return [float(times[row]) for row in _rows(names, len(times), "times")]
    if given is not None and given.stamps_s is not None and len(given) == len(names):
        return [float(stamp) for stamp in given.stamps_s]
    return [float(row) for row in range(len(names))]


def _poses(
    names: Sequence[str], stamps: Sequence[float], given: GivenPoses, *, is_timed: bool
) -> list[Array | None]:
    """The pose of each frame in recon's world, by its name, number, time or row."""
    if given.names is not None:
        return _by_name(names, given)
    if given.numbers is not None:
        row_of = {int(number): row for row, number in enumerate(given.numbers)}
        rows = [row_of.get(last_number(name) or 0) for name in names]
        return [None if row is None else given.row_in_world(row) for row in rows]
    if given.stamps_s is not None and is_timed:
        scaled = matched(given.stamps_s, np.array(stamps), "the poses")
        timed = replace(given, stamps_s=scaled)
        return [timed.in_world(stamp) for stamp in stamps]
    return [given.row_in_world(row) for row in _rows(names, len(given), "poses")]


def _by_name(names: Sequence[str], given: GivenPoses) -> list[Array | None]:
    """Poses of files whose stem is the frame's name or contains its number; left ones first."""
    rows: dict[str, int] = {}
    files = [*enumerate(given.names or ())]
    for row, name in sorted(files, key=lambda item: "right" in item[1].lower(), reverse=True):
        stem = Path(name).stem
        rows[str(last_number(stem))] = row
        rows[stem] = row
    keys = [name if name in rows else str(last_number(name)) for name in names]
    if not any(key in rows for key in keys):
        raise InputError(
            f"the poses are of {given.names[0] if given.names else 'no image'}, ..., but the "
            f"frames are named {names[0]}, ..."
        )
    return [given.row_in_world(rows[key]) if key in rows else None for key in keys]


def _rows(names: Sequence[str], num_rows: int, what: str) -> list[int]:
    if len(names) == num_rows:
        return [*range(num_rows)]
    numbers = [last_number(name) for name in names]
    known = [number for number in numbers if number is not None]
    start = known[0] if known and known[-1] - known[0] + 1 == num_rows else 0
    if len(known) < len(names) or max(known) - start >= num_rows:
        raise InputError(
            f"there are {num_rows} {what} for {len(names)} frames ({names[0]}, ...), but "
            "equally many are needed, or numbers in the names that identify the rows"
        )
    return [number - start for number in known]


def last_number(name: str) -> int | None:
    """The last whole number in a name, None if there is none."""
    numbers = re.findall(r"\d+", name)
    return int(numbers[-1]) if numbers else None


def read_times(path: Path) -> Array | None:
    """The first number of each line of a file, in seconds; None if there is no file.

    Milliseconds, microseconds and nanoseconds are detected by their size; dates with times (KITTI
    raw's "2011-09-26 13:02:25.964389445") are converted.

    Raises
    ------
    InputError
        With the line that is not a time.
    """
    if not path.is_file():
        return None
    times: list[float] = []
    for number, line in enumerate(read_lines(path), start=1):
        bare = line.partition("#")[0].replace(",", " ").strip()
        try:
            times += [_time(bare)] if bare else []
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {line[:40]!r} is not a time") from error
    check_finite(str(path), np.array(times))
    return in_seconds(np.array(times))


def _time(text: str) -> float:
    clock = re.match(r"(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d)(\.\d+)?", text)
    if clock is None:
        return float(text.split()[0])
    day = datetime.fromisoformat(f"{clock[1]}T{clock[2]}+00:00")
    return day.timestamp() + float(clock[3] or 0)
