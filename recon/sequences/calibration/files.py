"""Calibration files of every form, told apart by what they hold."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_finite
from recon.geometry import pose
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.yaml_files import read_yaml_calibration
from recon.sequences.poses import read_lines

Array = NDArray[np.float64]


def read_calibration(path: Path) -> Calibration:
    """The two cameras of a calibration file.

    KITTI's rows (3 x 4 projection matrices, with or without a label: the first two are left and
    right), Middlebury's keys, or the YAML of OpenCV 4 and 5 or Kalibr.

    Raises
    ------
    InputError
        With the line or the key that is wrong or missing.
    """
    lines = read_lines(path)
    if any(re.match(r"\s*cam0\s*=", line) for line in lines):
        return _middlebury(path, lines)
    if any(len(line.rpartition(":")[2].split()) == 12 for line in lines):
        return from_projections(*[*kitti_projections(path).values()][:2])
    return read_yaml_calibration(path)


def kitti_projections(path: Path) -> dict[str, Array]:
    """The (3, 4) projection matrices of KITTI's calib.txt, by their labels or lines.

    Raises
    ------
    InputError
        Where there are not two, or a row has not twelve numbers.
    """
    rows: dict[str, str] = {}
    for number, line in enumerate(read_lines(path), start=1):
        label, _, values = line.rpartition(":")
        if line.strip():
            rows[label.strip() or f"line {number}"] = values
    wanted = [name for name in rows if name.startswith(("P", "line"))]
    if len(wanted) < 2:
        raise InputError(f"{path} holds {len(wanted)} projection matrix, but two are needed")
    return {name: _matrix(path, rows, name, (3, 4)) for name in wanted}


def from_projections(left: Array, right: Array) -> Calibration:
    """Rectified cameras of two (3, 4) projections ``K [I | t]`` of one world."""
    cameras = [Camera(matrix=P[:, :3], distortion=np.zeros(0)) for P in (left, right)]
    t_left, t_right = (np.linalg.solve(P[:, :3], P[:, 3]) for P in (left, right))
    return Calibration(
        left=cameras[0], right=cameras[1], T_right_left=pose(np.eye(3), t_right - t_left)
    )


def _middlebury(path: Path, lines: list[str]) -> Calibration:
    """Middlebury 2014's keys; their millimetres become metres."""
    keys = {line.partition("=")[0].strip(): line.partition("=")[2] for line in lines}
    left, right = (_matrix(path, keys, name, (3, 3)) for name in ("cam0", "cam1"))
    size = None
    if "width" in keys and "height" in keys:
        size = (int(_number(path, keys, "width")), int(_number(path, keys, "height")))
    step = pose(np.eye(3), [-_number(path, keys, "baseline") / 1000.0, 0.0, 0.0])
    return Calibration(
        left=Camera(matrix=left, distortion=np.zeros(0), size=size),
        right=Camera(matrix=right, distortion=np.zeros(0), size=size),
        T_right_left=step,
        disparity_range=(0, int(_number(path, keys, "ndisp"))) if "ndisp" in keys else None,
    )


def _matrix(path: Path, keys: dict[str, str], name: str, shape: tuple[int, int]) -> Array:
    """The numbers of a key, row by row, brackets and semicolons left out."""
    fields = re.sub(r"[\[\];,]", " ", keys.get(name, "")).split()
    try:
        numbers = np.array([float(field) for field in fields]).reshape(shape)
        check_finite(f"{path}: {name}", numbers)
        return numbers
    except InputError:
        raise
    except ValueError as error:
        raise InputError(
            f"{path}: {name} is {keys.get(name, 'missing')!r:.80}, but "
            f"{shape[0] * shape[1]} numbers are needed"
        ) from error


def _number(path: Path, keys: dict[str, str], name: str) -> float:
    return float(_matrix(path, keys, name, (1, 1))[0, 0])
