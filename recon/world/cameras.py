"""The two simulated cameras: their poses, their gaze and their rig."""

from dataclasses import asdict, dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.errors import InputError, check_finite
from recon.geometry import Array, look_at, pose, rotation_about_y
from recon.records import View
from recon.settings.world import FOLLOWERS, EyesSettings
from recon.world.render import Camera

_PARAMETERS = ("focal_length", "fov_deg", "baseline", "near", "far")


def camera_settings(view: View, eyes: EyesSettings) -> EyesSettings:
    """The settings of the cameras, with the changes that the view makes.

    Raises
    ------
    InputError
        If a value of the view is invalid.
    """
    changes = {name: getattr(view, name) for name in _PARAMETERS if getattr(view, name) is not None}
    stay = {FOLLOWERS.get(name) for name in changes}.isdisjoint
    values = {name: value for name, value in asdict(eyes).items() if stay({name})}
    try:
        return EyesSettings(**values | changes)
    except InputError as error:
        raise InputError(f"view with {changes}: {error}") from error


def rig_of(view: View, eyes: EyesSettings) -> StereoRig:
    """The rectified rig that looks at the view's target with disparity 0.

    Principal points are shifted by half the disparity that the target would have: left by -s / 2,
    right by +s / 2, with s = f b / D and D the distance of the target.
    """
    focal_px = eyes.width / 2.0 / np.tan(np.radians(eyes.fov_deg) / 2.0)
    distance = np.linalg.norm(view.target - view.position)
    shift_px = focal_px * eyes.baseline / distance
    middle_px = (eyes.width - 1) / 2.0
    return StereoRig(
        width=eyes.width,
        height=eyes.height,
        focal_px=float(focal_px),
        cx_left_px=float(middle_px - shift_px / 2.0),
        cx_right_px=float(middle_px + shift_px / 2.0),
        cy_px=(eyes.height - 1) / 2.0,
        baseline=eyes.baseline,
        residual_px=0.0,
    )


def left_pose(view: View, baseline: float) -> Array:
    """`T_world_left` (4, 4): the left camera, half the baseline beside the view's position."""
    check_finite("view position", view.position)
    check_finite("view target", view.target)
    T_world_left = look_at(view.position, view.target)
    T_world_left[:3, 3] -= 0.5 * baseline * T_world_left[:3, 0]
    return T_world_left


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RectifiedCamera:
    """The rays of one camera, and the homography of its image into the rectified rig."""

    camera: Camera
    H_rectified_camera: Array | None
    """(3, 3) mapping of image points; None if the image is already rectified."""


def camera_of(
    T_world_camera: Array, rig: StereoRig, cx_px: float, eyes: EyesSettings
) -> RectifiedCamera:
    """The camera at a pose of the rig, with principal point `cx_px` in the rig.

    With gaze "shift" the sensor is shifted; with "toe-in" the camera turns until the target is in
    the middle of the image, as with the shifted sensor.
    """
    middle_px = (eyes.width - 1) / 2.0
    K_rig = _intrinsics(rig.focal_px, cx_px, rig.cy_px)
    if eyes.gaze == "shift":
        return RectifiedCamera(camera=_camera(T_world_camera, K_rig, eyes), H_rectified_camera=None)
    turn = pose(rotation_about_y(np.arctan((middle_px - cx_px) / rig.focal_px)), np.zeros(3))
    K_camera = _intrinsics(rig.focal_px, middle_px, rig.cy_px)
    return RectifiedCamera(
        camera=_camera(T_world_camera @ turn, K_camera, eyes),
        H_rectified_camera=K_rig @ turn[:3, :3] @ np.linalg.inv(K_camera),
    )


def rectified(image: NDArray[np.uint8], H_rectified_camera: Array | None) -> NDArray[np.uint8]:
    """The image (H, W, 3) warped to the rectified rig; its border is replicated."""
    if H_rectified_camera is None:
        return image
    moved: NDArray[np.uint8] = cv2.warpPerspective(
        image,
        H_rectified_camera,
        image.shape[1::-1],
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return moved


def _intrinsics(focal_px: float, cx_px: float, cy_px: float) -> Array:
    return np.array([[focal_px, 0.0, cx_px], [0.0, focal_px, cy_px], [0.0, 0.0, 1.0]])


def _camera(T_world_camera: Array, K: Array, eyes: EyesSettings) -> Camera:
    """Rays of a camera: (u, v) has direction ``R K^-1 (u, v, 1)``, so that depth is along z."""
    directions = T_world_camera[:3, :3] @ np.linalg.inv(K)
    still = np.zeros(3)
    return Camera(
        width=eyes.width,
        height=eyes.height,
        near=eyes.near,
        far=eyes.far,
        frame=np.array(
            [
                T_world_camera[:3, 3],
                directions[:, 2],
                still,
                directions[:, 0],
                still,
                directions[:, 1],
            ]
        ),
    )
