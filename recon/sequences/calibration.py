"""What is known of the two cameras of a rig, as it was measured, rectified or not."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_finite, check_shape
from recon.geometry import check_rigid, pose
from recon.sequences.poses import read_lines

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """Intrinsics of one camera; pixel (0, 0) is the CENTRE of the top-left pixel."""

    matrix: Array
    """(3, 3) focal lengths and principal point, pixels."""
    distortion: Array
    """(n,) in OpenCV's order; none, 4, 5, 8, 12 or 14 (4 where `is_fisheye`)."""
    is_fisheye: bool = False
    """Equidistant (Kannala-Brandt) rather than radial-tangential."""
    size: tuple[int, int] | None = None
    """(width, height) in pixels, None where the file does not say."""

    def __post_init__(self) -> None:
        check_shape("camera matrix", self.matrix, (3, 3))
        check_finite("camera matrix", self.matrix)
        check_finite("distortion", self.distortion)
        if not (np.diag(self.matrix) > 0).all():
            raise InputError(
                f"focal lengths are {self.matrix[0, 0]:g} and {self.matrix[1, 1]:g}, "
                "but positive numbers are needed"
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """Two cameras and how they stand to each other."""

    left: Camera
    right: Camera
    T_right_left: Array
    """(4, 4) brings points of the left camera into the right one's frame; world units."""
    disparity_range: tuple[int, int] | None = None
    """(min, max) that occur, both included, where the file says (Middlebury's ndisp)."""

    def __post_init__(self) -> None:
        check_rigid("T_right_left", self.T_right_left)
        if not self.baseline > 0:
            raise InputError("the two cameras stand at one place, but a baseline is needed")

    @property
    def baseline(self) -> float:
        """Distance of the two eyes, world units."""
        return float(np.linalg.norm(self.T_right_left[:3, 3]))

    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height) that the calibration is for, None where it does not say."""
        return self.left.size or self.right.size

    @property
    def is_rectified(self) -> bool:
        """Whether rows correspond as they are.

        Published rigs that are rectified (KITTI's colour cameras) still state some millimetres
        of offset along y and z, which nobody applies: a hundredth of the baseline is let pass.
        """
        across = np.abs(self.T_right_left[1:3, 3]).max() <= 0.01 * self.baseline
        aligned = np.abs(self.T_right_left[:3, :3] - np.eye(3)).max() < 1e-9
        straight = not self.left.distortion.any() and not self.right.distortion.any()
        return bool(
            across and aligned and straight and _same_rows(self.left.matrix, self.right.matrix)
        )


def _same_rows(left: Array, right: Array) -> bool:
    """Square pixels of one size, principal points in one row."""
    focal = np.array([left[0, 0], left[1, 1], right[0, 0], right[1, 1]])
    return bool(np.ptp(focal) <= 1e-6 * focal[0] and abs(left[1, 2] - right[1, 2]) <= 1e-6)


def read_calibration(path: Path) -> Calibration:
    """A calibration, whose form is told by what the file holds.

    KITTI rows (3 x 4 projection matrices, with or without a label: the first two are left and
    right) or Middlebury's keys.

    Raises
    ------
    InputError
        With the line or the key that is wrong or missing.
    """
    lines = read_lines(path)
    if any(line.strip().startswith("cam0=") for line in lines):
        return _middlebury(path, lines)
    matrices = [*kitti_projections(path).values()]
    if len(matrices) < 2:
        raise InputError(f"{path} holds {len(matrices)} projection matrices, but two are needed")
    return from_projections(matrices[0], matrices[1])


def kitti_projections(path: Path) -> dict[str, Array]:
    """The (3, 4) projection matrices of KITTI's calib.txt by their labels, or by "0", "1", ..."""
    rows: dict[str, str] = {}
    for number, line in enumerate(read_lines(path), start=1):
        label, _, values = line.rpartition(":")
        if line.strip():
            rows[label.strip() or f"line {number}"] = values
    wanted = [name for name in rows if name.startswith(("P", "line"))]
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
        return np.array([float(field) for field in fields]).reshape(shape)
    except ValueError as error:
        raise InputError(
            f"{path}: {name} is {keys.get(name, 'missing')!r:.80}, but "
            f"{shape[0] * shape[1]} numbers are needed"
        ) from error


def _number(path: Path, keys: dict[str, str], name: str) -> float:
    return float(_matrix(path, keys, name, (1, 1))[0, 0])
