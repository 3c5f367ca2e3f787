"""Rectification: aligns the rows of both images, computed once per rig."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError, check_type
from recon.geometry import pose
from recon.notices import notify
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.depth import Image
from recon.sequences.pair_images import alike

Array = NDArray[np.float64]
MAX_OFF_CENTRE = 0.14
"""Maximum offset of the mean principal point from the centre, as a share of the image size.

Published rigs are below 0.1; images enlarged by half have 0.17, halved ones are at the edge.
"""
MAX_ZOOM = 3.0
"""Maximum ratio of the rectified focal length to the raw one; lenses and slight turns make 1.3."""
LEAST_ASIDE = 1e-6
"""Smallest sine of the angle between the direction of view and the baseline."""
Maps = tuple[NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rectifier:
    """Warps raw images to the rectified rig; without maps they are already rectified."""

    rig: StereoRig
    raw_size: tuple[int, int]
    """(width, height) of the raw images."""
    T_raw_rectified: Array
    """(4, 4) from the rectified left frame into the left camera's own: a pure rotation."""
    maps: tuple[Maps, Maps] | None = None
    """(u, v) of the source pixel of each rectified one, left and right."""
    disparity_range: tuple[int, int] | None = None
    """(min, max) in pixels, both included, if the calibration states it."""

    def __call__(self, left: Image, right: Image) -> tuple[Image, Image]:
        """The two images warped to the rectified rig; areas outside the raw images are black."""
        for side, image in (("left", left), ("right", right)):
            if image.shape[1::-1] != self.raw_size:
                raise InputError(
                    f"the {side} image has {image.shape[1]} x {image.shape[0]} pixels, but "
                    f"{self.raw_size[0]} x {self.raw_size[1]} are needed"
                )
        if self.maps is None:
            return left, right
        left_maps, right_maps = self.maps
        return (
            cv2.remap(left, *left_maps, cv2.INTER_LINEAR),
            cv2.remap(right, *right_maps, cv2.INTER_LINEAR),
        )

    def pair(
        self,
        left: Image,
        right: Image,
        T_world_raw: Array | None = None,
        stamp_s: float = 0.0,
        name: str = "pair",
    ) -> StereoPair:
        """The rectified pair from raw images, with the left camera at `T_world_raw`."""
        check_type("left image", left, np.ndarray)
        check_type("right image", right, np.ndarray)
        left, right = self(*alike(left, right))
        return StereoPair(
            left=left,
            right=right,
            rig=self.rig,
            T_world_left=None if T_world_raw is None else T_world_raw @ self.T_raw_rectified,
            stamp_s=stamp_s,
            name=name,
            disparity_range=self.disparity_range,
        )


def rectifier(calibration: Calibration, size: tuple[int, int]) -> Rectifier:
    """The rectification of raw images of `size` (width, height).

    Raises
    ------
    InputError
        If the calibration is for images of another size, or has left and right swapped.
    """
    _check_size(calibration, size)
    _say_centre(calibration, size)
    _check_sides(calibration)
    if calibration.is_rectified:
        return Rectifier(
            rig=_rectified_rig(calibration, size), raw_size=size, T_raw_rectified=np.eye(4)
        )
    rotation = common_axes(calibration.T_right_left)
    rig = _filled_rig(calibration, size, rotation)
    _say_zoom(calibration, rig)
    return warping(calibration, size, rotation, rig)


def common_axes(T_right_left: Array) -> Array:
    """Rows x, y, z (3, 3) of the rectified frame in the left camera's.

    x points along the baseline, z is as close to both optical axes as possible. A rig with a
    vertical baseline is thereby rotated by a quarter turn, without a special case.

    Raises
    ------
    InputError
        If the cameras look along the baseline.
    """
    R = T_right_left[:3, :3]
    x = -R.T @ T_right_left[:3, 3]
    x /= np.linalg.norm(x)
    forward = np.array([0.0, 0.0, 1.0]) + R[2]
    y = np.cross(forward, x)
    if np.linalg.norm(y) < LEAST_ASIDE * np.linalg.norm(forward):
        raise InputError("according to the calibration the cameras look along their baseline")
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)])


def warping(
    calibration: Calibration, size: tuple[int, int], rotation: Array, rig: StereoRig
) -> Rectifier:
    """The rectifier with axes `rotation` (`common_axes`) and the intrinsics of `rig`."""
    R_rectified_right = rotation @ calibration.T_right_left[:3, :3].T
    return Rectifier(
        rig=rig,
        raw_size=size,
        T_raw_rectified=pose(rotation.T, np.zeros(3)),
        maps=(
            _maps(calibration.left, rotation, rig, rig.cx_left_px),
            _maps(calibration.right, R_rectified_right, rig, rig.cx_right_px),
        ),
    )


def _maps(camera: Camera, rotation: Array, rig: StereoRig, cx_px: float) -> Maps:
    K = np.array([[rig.focal_px, 0, cx_px], [0, rig.focal_px, rig.cy_px], [0, 0, 1]])
    lens = cv2.fisheye if camera.is_fisheye else cv2
    u, v = lens.initUndistortRectifyMap(
        camera.matrix, camera.distortion, rotation, K, (rig.width, rig.height), cv2.CV_32FC1
    )
    return u, v


def _filled_rig(calibration: Calibration, size: tuple[int, int], rotation: Array) -> StereoRig:
    """The widest view of the raw size in which both images have no empty border (alpha 0)."""
    R_rectified_right = rotation @ calibration.T_right_left[:3, :3].T
    inner = np.array(
        [
            _inner_rectangle(calibration.left, size, rotation),
            _inner_rectangle(calibration.right, size, R_rectified_right),
        ]
    )
    low, high = inner[:, 0].max(axis=0), inner[:, 1].min(axis=0)
    if not (low < high).all():
        raise InputError("according to the calibration the two cameras share no field of view")
    lies_across = abs(rotation[0, 1]) > abs(rotation[0, 0])
    width, height = size[::-1] if lies_across else size
    focal = float(np.max((np.array([width, height]) - 1) / (high - low)))
    cx, cy = (np.array([width, height]) - 1) / 2 - focal * (low + high) / 2
    return StereoRig(
        width=width,
        height=height,
        focal_px=focal,
        cx_left_px=float(cx),
        cx_right_px=float(cx),
        cy_px=float(cy),
        baseline=calibration.baseline,
        residual_px=calibration.residual_px,
    )


def _inner_rectangle(camera: Camera, size: tuple[int, int], rotation: Array) -> Array:
    """[[x_min, y_min], [x_max, y_max]] at z = 1, covered by the raw image."""
    border = _border_rays(camera, size, rotation)
    middle = (border.min(axis=0) + border.max(axis=0)) / 2
    relative = (border - middle) / np.ptp(border, axis=0)
    is_side = np.abs(relative[:, 0]) > np.abs(relative[:, 1])
    sides, ends = border[is_side, 0], border[~is_side, 1]
    low = sides[sides < middle[0]], ends[ends < middle[1]]
    high = sides[sides > middle[0]], ends[ends > middle[1]]
    if not all(map(len, (*low, *high))):
        raise InputError(
            "according to the calibration the cameras look too far apart to be rectified"
        )
    return np.array([[part.max() for part in low], [part.min() for part in high]])


def _border_rays(camera: Camera, size: tuple[int, int], rotation: Array) -> Array:
    across, down = (np.linspace(0.0, extent - 1.0, 101) for extent in size)
    ends = [(across, np.full(101, v)) for v in (0.0, size[1] - 1.0)]
    sides = [(np.full(101, u), down) for u in (0.0, size[0] - 1.0)]
    border = np.concatenate([np.column_stack(line) for line in ends + sides])[:, None]
    lens = cv2.fisheye if camera.is_fisheye else cv2
    rays: Array = lens.undistortPoints(border, camera.matrix, camera.distortion, R=rotation)
    return rays[:, 0]


def _check_size(calibration: Calibration, size: tuple[int, int]) -> None:
    for side, camera in (("left", calibration.left), ("right", calibration.right)):
        centre = (camera.matrix[0, 2], camera.matrix[1, 2])
        inside = all(0 <= c <= extent for c, extent in zip(centre, size, strict=True))
        if camera.size in (None, size) and inside:
            continue
        said = f"a principal point at {centre[0]:g}, {centre[1]:g}"
        if camera.size not in (None, size):
            said = "{} x {} pixels".format(*camera.size)
        raise InputError(
            f"images have {size[0]} x {size[1]} pixels, but the {side} camera's "
            f"calibration is for {said}"
        )


def _say_centre(calibration: Calibration, size: tuple[int, int]) -> None:
    """Notify if the principal points are so far off that images may be cropped or scaled."""
    if calibration.size is not None:
        return
    matrices = calibration.left.matrix, calibration.right.matrix
    shares = np.mean([matrix[:2, 2] for matrix in matrices], axis=0) / size
    if (np.abs(shares - 0.5) > MAX_OFF_CENTRE).any():
        notify(
            "calibration-off-centre",
            f"the principal point lies at {shares[0]:.0%} of the width and {shares[1]:.0%} of the "
            f"height of {size[0]} x {size[1]} pixels: is the calibration for images of this size?",
        )


def _say_zoom(calibration: Calibration, rig: StereoRig) -> None:
    """Notify if hardly any of the images remains, as with a distortion that no lens has."""
    focal = calibration.left.matrix[0, 0]
    if rig.focal_px > MAX_ZOOM * focal:
        notify(
            "calibration-contradictory",
            f"rectified images are enlarged {rig.focal_px / focal:.3g} times (focal lengths "
            f"{rig.focal_px:.0f} and {focal:.0f} px): are distortion and rotation right?",
        )


def _check_sides(calibration: Calibration) -> None:
    if calibration.is_swapped:
        raise InputError(
            f"according to the calibration the right camera is {calibration.baseline:g} to the "
            "left of the left one: the images or the cameras are swapped"
        )


def _rectified_rig(calibration: Calibration, size: tuple[int, int]) -> StereoRig:
    left, right = calibration.left.matrix, calibration.right.matrix
    return StereoRig(
        width=size[0],
        height=size[1],
        focal_px=float(left[0, 0]),
        cx_left_px=float(left[0, 2]),
        cx_right_px=float(right[0, 2]),
        cy_px=float(left[1, 2]),
        baseline=float(-calibration.T_right_left[0, 3]),
        residual_px=calibration.residual_px,
    )
