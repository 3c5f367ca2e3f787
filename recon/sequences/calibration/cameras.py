"""Calibrations of the two cameras of a rig, raw or rectified."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.errors import InputError, check_finite, check_number, check_shape
from recon.geometry import check_rigid, invert, pose

Array = NDArray[np.float64]

MAX_NUMBER = 1e15
RESIDUAL = "residual_px"
"""Key of a calibration's residual, in the files that can state one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """Intrinsics of one camera; pixel (0, 0) is the CENTRE of the top-left pixel."""

    matrix: Array
    """(3, 3) focal lengths and principal point, pixels."""
    distortion: Array
    """(n,) in OpenCV's order: 0, 4, 5, 8, 12 or 14 numbers; 4 if `is_fisheye`."""
    is_fisheye: bool = False
    """Equidistant (Kannala-Brandt) rather than radial-tangential."""
    size: tuple[int, int] | None = None
    """(width, height) in pixels, None if the file does not state it."""

    def __post_init__(self) -> None:
        check_shape("camera matrix", self.matrix, (3, 3))
        for name, values in (("camera matrix", self.matrix), ("distortion", self.distortion)):
            check_finite(name, values)
            check_magnitude(name, values)
        numbers = (0, 4) if self.is_fisheye else (0, 4, 5, 8, 12, 14)
        if self.distortion.shape not in [(number,) for number in numbers]:
            raise InputError(
                f"distortion has {self.distortion.size} numbers, but one of {numbers} is needed"
            )
        if np.abs(self.matrix[[1, 2, 2], [0, 0, 1]]).max() > 1e-6 or self.matrix[2, 2] != 1.0:
            raise InputError(
                f"camera matrix is {self.matrix.round(3).tolist()}, but rows fx s cx, 0 fy cy, "
                "0 0 1 are needed"
            )
        if not (np.diag(self.matrix) > 0).all():
            raise InputError(
                f"focal lengths are {self.matrix[0, 0]:g} and {self.matrix[1, 1]:g}, "
                "but positive numbers are needed"
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """Two cameras and their relative pose."""

    left: Camera
    right: Camera
    T_right_left: Array
    """(4, 4) transform from the left camera's frame to the right one's; world units."""
    disparity_range: tuple[int, int] | None = None
    """(min, max) that occur, both included, if the file states it (Middlebury's ndisp)."""
    residual_px: float = TYPICAL_RESIDUAL_PX
    """See `StereoRig.residual_px`."""

    def __post_init__(self) -> None:
        check_rigid("T_right_left", self.T_right_left)
        check_magnitude("T_right_left", self.T_right_left)
        check_number("residual_px", self.residual_px, low=0)
        if not self.baseline > 0:
            raise InputError("both cameras have the same position, but a baseline is needed")

    @property
    def baseline(self) -> float:
        """Distance of the two cameras, world units."""
        return float(np.linalg.norm(self.T_right_left[:3, 3]))

    @property
    def is_swapped(self) -> bool:
        """True if the right camera is to the left of the left one."""
        x, y, _ = invert(self.T_right_left)[:3, 3]
        return bool(-x > abs(y))

    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height) that the calibration is for, None if not stated."""
        return self.left.size or self.right.size

    @property
    def is_rectified(self) -> bool:
        """True if rows correspond without rectification.

        Published rectified rigs (KITTI's colour cameras) still state offsets of some millimetres
        along y and z, which are not applied: up to a hundredth of the baseline is tolerated.
        """
        across = np.abs(self.T_right_left[1:3, 3]).max() <= 0.01 * self.baseline
        aligned = np.abs(self.T_right_left[:3, :3] - np.eye(3)).max() < 1e-9
        straight = not self.left.distortion.any() and not self.right.distortion.any()
        return bool(
            across and aligned and straight and _same_rows(self.left.matrix, self.right.matrix)
        )


def check_magnitude(name: str, numbers: Array) -> None:
    """Raise `InputError` for a number whose square would lose all precision."""
    largest = float(np.abs(numbers).max(initial=0.0))
    if largest > MAX_NUMBER:
        raise InputError(f"{name} contains {largest:g}, but at most {MAX_NUMBER:g} is allowed")


def from_projections(
    left: Array, right: Array, *, size: tuple[int, int] | None = None
) -> Calibration:
    """Rectified cameras from two (3, 4) projections ``K [I | t]`` of the same world."""
    cameras = [Camera(matrix=P[:, :3], distortion=np.zeros(0), size=size) for P in (left, right)]
    step = projected_step(right) - projected_step(left)
    return Calibration(left=cameras[0], right=cameras[1], T_right_left=pose(np.eye(3), step))


def projected_step(projection: Array) -> Array:
    """The translation t (3,) of a projection ``K [I | t]`` (3, 4)."""
    try:
        step = np.linalg.solve(projection[:, :3], projection[:, 3]).astype(np.float64)
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"projection matrix is {projection.tolist()}, but that of a camera is needed"
        ) from error
    return step


def _same_rows(left: Array, right: Array) -> bool:
    """Test for square pixels of equal size, and principal points in the same row."""
    focal = np.array([left[0, 0], left[1, 1], right[0, 0], right[1, 1]])
    return bool(np.ptp(focal) <= 1e-6 * focal[0] and abs(left[1, 2] - right[1, 2]) <= 1e-6)
