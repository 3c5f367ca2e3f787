"""Pose files, identified by content: KITTI, TUM, EuRoC, OpenVINS, COLMAP, nerfstudio."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.notices import notify
from recon.sequences.calibration.rigid import made_rigid, say_rigid
from recon.sequences.posed_images import is_colmap, read_colmap, read_nerfstudio
from recon.sequences.poses import GivenPoses
from recon.sequences.text import is_finite, read_lines
from recon.sequences.units import in_seconds

Array = NDArray[np.float64]

KITTI_COLUMNS = {12: 0, 13: 1, 16: 0, 17: 1}
"""Columns of rows of 3 x 4 or 4 x 4 numbers; 1 if the frame number comes first."""
ROUNDED = 1e-3
"""Largest error of a quaternion's length that three digits cause."""
MIN_TIMED_COLUMNS = 8
"""Time, position, quaternion; velocities, biases, covariances may follow."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Table:
    """Rows of numbers of a text file."""

    path: Path
    lines: list[int]
    """Line numbers in the file, starting at 1."""
    rows: list[list[float]]
    heading: str
    """The comment before the first row."""
    has_commas: bool

    @property
    def columns(self) -> set[int]:
        """The row lengths that occur."""
        return {len(row) for row in self.rows}


def read_poses(path: Path) -> GivenPoses:
    """Poses of a file, in the world of the recording.

    KITTI's rows of 12 numbers, TUM's of 8, EuRoC's and VINS-Fusion's with commas (the quaternion
    begins with w), OpenVINS's with covariances, KITTI-360's with the number of the frame first,
    COLMAP's images.txt, nerfstudio's transforms.json.

    Raises
    ------
    InputError
        With the line that is not a pose, or whose time goes back.
    """
    if path.suffix.lower() == ".json":
        return read_nerfstudio(path)
    lines = read_lines(path)
    if is_colmap(lines):
        return read_colmap(path, lines)
    table = _table(path, lines)
    widths = table.columns
    if len(widths) == 1 and not table.has_commas and widths <= KITTI_COLUMNS.keys():
        return _kitti(table)
    if min(widths) >= MIN_TIMED_COLUMNS and (table.has_commas or len(widths) == 1):
        return _timed(table)
    odd = next((n for n, row in zip(table.lines, table.rows, strict=True)
                if len(row) not in (8, 12)), 1)  # fmt: skip
    raise InputError(
        f"{path}, line {odd}: rows have {sorted(widths)} numbers, but 12 (KITTI), 8 (TUM) "
        "or EuRoC's with commas are needed"
    )


def _table(path: Path, lines: list[str]) -> _Table:
    numbers: list[int] = []
    rows: list[list[float]] = []
    heading, has_commas = "", False
    for number, line in enumerate(lines, start=1):
        bare, mark, comment = line.partition("#")
        bare = bare.strip().rstrip(",")
        if not rows and mark and not bare:
            heading = comment
        if not bare:
            continue
        fields = bare.replace(",", " ").split()
        if not all(is_finite(field) for field in fields):
            if not rows and not heading and _is_heading(fields):
                heading = bare
                continue
            raise InputError(f"{path}, line {number}: {bare[:60]!r}, but finite numbers are needed")
        has_commas = has_commas or "," in bare
        numbers.append(number)
        rows.append([float(field) for field in fields])
    if not rows:
        raise InputError(f"{path} holds no pose")
    return _Table(path=path, lines=numbers, rows=rows, heading=heading, has_commas=has_commas)


def _is_heading(fields: list[str]) -> bool:
    """True if the words of a first line are column names."""
    return len(fields) >= MIN_TIMED_COLUMNS and not any(is_finite(field) for field in fields)


def _kitti(table: _Table) -> GivenPoses:
    values = np.array(table.rows)
    first = KITTI_COLUMNS[values.shape[1]]
    matrices = values[:, first : first + 12].reshape(-1, 3, 4)
    poses = [pose(matrix[:, :3], matrix[:, 3]) for matrix in matrices]
    return GivenPoses(
        poses=_rigid(table, poses), numbers=values[:, 0].astype(np.int64) if first else None
    )


def _timed(table: _Table) -> GivenPoses:
    values = np.array([row[:MIN_TIMED_COLUMNS] for row in table.rows])
    position, quaternion = _order(table)
    stamps = in_seconds(values[:, 0])
    kept = _rising(table, stamps)
    with np.errstate(over="ignore"):
        norms = np.linalg.norm(values[:, quaternion], axis=1)
    bad = np.flatnonzero(np.abs(norms - 1.0) > 0.1)
    if bad.size:
        raise InputError(
            f"{table.path}, line {table.lines[bad[0]]}: the quaternion has length "
            f"{norms[bad[0]]:.3g}, but 1 is needed"
        )
    _say_lengths(table, norms)
    turns = Rotation.from_quat(values[:, quaternion]).as_matrix()
    poses = [pose(R, t) for R, t in zip(turns, values[:, position], strict=True)]
    return GivenPoses(poses=np.stack(poses)[kept], stamps_s=stamps[kept])


def _say_lengths(table: _Table, norms: Array) -> None:
    """Notify of quaternions whose length rounding does not explain: another column may be meant."""
    worst = int(np.argmax(np.abs(norms - 1.0)))
    if abs(norms[worst] - 1.0) > ROUNDED:
        notify(
            "rotation-made-rigid",
            f"{table.path}, line {table.lines[worst]}: the quaternion has length "
            f"{norms[worst]:.4g}, not 1: it is scaled to it",
        )


def _order(table: _Table) -> tuple[list[int], list[int]]:
    """Columns of x, y, z and of the quaternion's x, y, z, w.

    The heading decides; without one, w comes first in comma-separated files (EuRoC) and last in
    space-separated ones (TUM).
    """
    names = re.sub(r"[\[(][^\])]*[\])]", "", table.heading.lower()).replace(",", " ").split()
    axes = [name[-1] if name.startswith("q") else "" for name in names[:MIN_TIMED_COLUMNS]]
    if sorted(axis for axis in axes if axis) == ["w", "x", "y", "z"]:
        quaternion = [axes.index(axis) for axis in "xyzw"]
    else:
        quaternion = [5, 6, 7, 4] if table.has_commas else [4, 5, 6, 7]
    position = [4, 5, 6] if 4 not in quaternion else [1, 2, 3]
    return ([5, 6, 7] if 1 in quaternion else position), quaternion


def _rising(table: _Table, stamps: Array) -> NDArray[np.bool_]:
    """(N,) mask of rows whose time differs from the previous one; decreasing times are refused."""
    steps = np.diff(stamps, prepend=-np.inf)
    if (steps < 0).any():
        raise InputError(
            f"{table.path}, line {table.lines[int(np.argmax(steps < 0))]}: the time is before that "
            "of the previous row"
        )
    again = np.flatnonzero(steps == 0)
    if again.size:
        notify(
            "stamps-repeated",
            f"{table.path}, line {table.lines[again[0]]}: {again.size} poses have the same time as "
            "the previous one and are left out",
        )
    kept: NDArray[np.bool_] = steps > 0
    return kept


def _rigid(table: _Table, poses: list[Array]) -> Array:
    exact = [
        made_rigid(f"{table.path}, line {line}: the pose", T)
        for line, T in zip(table.lines, poses, strict=True)
    ]
    worst = int(np.argmax([error for _, error in exact]))
    say_rigid(f"{table.path}, line {table.lines[worst]}: the pose", exact[worst][1])
    return np.stack([T for T, _ in exact])
