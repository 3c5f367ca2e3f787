"""Calibrations as lines of text: KITTI's projections, KITTI raw's, Middlebury's keys."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.errors import InputError, check_finite
from recon.geometry import pose
from recon.notices import notify
from recon.sequences.calibration.cameras import (
    RESIDUAL,
    Calibration,
    Camera,
    from_projections,
    projected_step,
)
from recon.sequences.calibration.documents import MAX_BYTES
from recon.sequences.text import is_finite, read_lines

Array = NDArray[np.float64]
Cameras = tuple[int, int]
"""Numbers of the left and the right camera, as KITTI numbers its four."""

MAX_CAMERAS = 8
"""Maximum number of unlabelled projections; more are poses."""
MAX_DOFFS_PX = 1.0
"""Error of Middlebury's doffs that rounding explains."""
SMALLEST_MM = 1.0
"""No two cameras are nearer to each other."""
MIN_FOCAL_PX = 2.0
"""A matrix with a smaller focal length is a pose."""


def is_middlebury(lines: Sequence[str]) -> bool:
    """True if there is a key cam0=."""
    return any(re.match(r"\s*cam0\s*=", line) for line in lines)


def is_kitti(lines: Sequence[str]) -> bool:
    """True if a row has twelve numbers after its label."""
    return any(len(_fields(line)) == 12 and all(map(is_finite, _fields(line))) for line in lines)


def _fields(line: str) -> list[str]:
    return line.rpartition(":")[2].split()


def middlebury(path: Path) -> Calibration:
    """Middlebury 2014's keys, with millimetres converted to metres."""
    lines = read_lines(path, MAX_BYTES)
    keys = {line.partition("=")[0].strip(): line.partition("=")[2] for line in lines}
    left, right = (_matrix(path, keys, name, (3, 3)) for name in ("cam0", "cam1"))
    size = None
    if "width" in keys and "height" in keys:
        size = (_count(path, keys, "width"), _count(path, keys, "height"))
    _check_doffs(path, keys, right[0, 2] - left[0, 2])
    step = pose(np.eye(3), [-_baseline(path, keys), 0.0, 0.0])
    return Calibration(
        left=Camera(matrix=left, distortion=np.zeros(0), size=size),
        right=Camera(matrix=right, distortion=np.zeros(0), size=size),
        T_right_left=step,
        disparity_range=(0, _count(path, keys, "ndisp")) if "ndisp" in keys else None,
        residual_px=_number(path, keys, RESIDUAL) if RESIDUAL in keys else TYPICAL_RESIDUAL_PX,
    )


def _baseline(path: Path, keys: dict[str, str]) -> float:
    """The baseline in metres; one stated in metres causes a notice."""
    stated_mm = _number(path, keys, "baseline")
    if 0.0 < stated_mm < SMALLEST_MM:
        notify(
            "calibration-contradictory",
            f"{path}: baseline is {stated_mm:g}, which these files state in millimetres; if it is "
            f"in metres, write {1000.0 * stated_mm:g}",
        )
    return stated_mm / 1000.0


def _check_doffs(path: Path, keys: dict[str, str], apart_px: float) -> None:
    """Notify if the stated offset of the disparities is not that of the principal points."""
    if "doffs" in keys and abs((doffs := _number(path, keys, "doffs")) - apart_px) > MAX_DOFFS_PX:
        notify(
            "calibration-contradictory",
            f"{path}: doffs is {doffs:g}, but the principal points of cam0 and cam1 are "
            f"{apart_px:g} px apart, as is used",
        )


def kitti(path: Path, cameras: Cameras | None = None) -> Calibration:
    """Two projections: those of the requested cameras, else the first two."""
    rows = kitti_projections(path)
    left, right = chosen(rows, cameras)
    size = _rectified_size(path, left)
    return from_projections(rows[left], rows[right], size=size)


def kitti_projections(path: Path) -> dict[str, Array]:
    """The (3, 4) projection matrices of a KITTI file, by their labels or lines.

    Raises
    ------
    InputError
        If there are fewer than two, a row does not have twelve numbers, or the rows are poses.
    """
    rows = _labelled(path)
    wanted = [name for name in rows if re.match(r"P\d|P_rect|P$|line", name)]
    if len(wanted) < 2:
        raise InputError(f"{path} holds {len(wanted)} projection matrix, but two are needed")
    found = {name: _matrix(path, rows, name, (3, 4)) for name in wanted}
    if len(found) > MAX_CAMERAS or any(_is_pose(P) for P in found.values()):
        raise InputError(f"{path} holds poses, but a calibration is needed")
    return found


def chosen(names: Sequence[str] | dict[str, Array], cameras: Cameras | None) -> tuple[str, str]:
    """The labels of two cameras by their numbers; the first two if there are none of that name."""
    for form in ("P{0}", "P_rect_{0:02d}", "P_rect_{0}"):
        labels = [form.format(number) for number in cameras or ()]
        if labels and all(label in names for label in labels):
            return labels[0], labels[1]
    first, second = [*names][:2]
    return first, second


def T_camera0_left(path: Path, cameras: Cameras) -> Array:
    """Pose of the left camera in the frame of camera 0, from its projection ``K [I | t]``."""
    rows = kitti_projections(path)
    P = rows[chosen(rows, cameras)[0]]
    return pose(np.eye(3), -projected_step(P))


def _labelled(path: Path) -> dict[str, str]:
    rows: dict[str, str] = {}
    for number, line in enumerate(read_lines(path, MAX_BYTES), start=1):
        label, _, values = line.rpartition(":")
        if line.strip() and not line.lstrip().startswith("#"):
            rows[label.strip() or f"line {number}"] = values
    return rows


def _is_pose(P: Array) -> bool:
    """True if a (3, 4) matrix has the focal length of a rotation."""
    return bool(np.abs(P[:2, :2]).max() < MIN_FOCAL_PX)


def _rectified_size(path: Path, label: str) -> tuple[int, int] | None:
    """KITTI raw's S_rect_0N of a projection P_rect_0N."""
    rows = _labelled(path)
    name = label.replace("P_rect", "S_rect")
    if name == label or name not in rows:
        return None
    width, height = _matrix(path, rows, name, (2, 1)).ravel()
    return round(width), round(height)


def _matrix(path: Path, keys: dict[str, str], name: str, shape: tuple[int, int]) -> Array:
    """The numbers of a key, row by row, ignoring brackets and semicolons."""
    fields = re.sub(r"[\[\];,]", " ", keys.get(name, "")).split()
    try:
        values = np.array([float(field) for field in fields]).reshape(shape)
    except ValueError as error:
        raise InputError(
            f"{path}: {name} is {keys.get(name, 'missing')!r:.80}, but "
            f"{shape[0] * shape[1]} numbers are needed"
        ) from error
    check_finite(f"{path}: {name}", values)
    return values


def _number(path: Path, keys: dict[str, str], name: str) -> float:
    return float(_matrix(path, keys, name, (1, 1))[0, 0])


def _count(path: Path, keys: dict[str, str], name: str) -> int:
    number = _number(path, keys, name)
    if not 0 < number < 1e6:
        raise InputError(f"{path}: {name} is {number:g}, but a positive whole number is needed")
    return int(number)
