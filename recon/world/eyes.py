"""The two simulated cameras: where they stand, how they look, and what they are."""

from dataclasses import asdict

import numpy as np

from recon.camera import StereoRig
from recon.errors import InputError, check_finite
from recon.geometry import Array, look_at
from recon.records import View
from recon.settings.world import FOLLOWERS, EyesSettings
from recon.world.render import Camera

_PARAMETERS = ("focal_length", "fov_deg", "baseline", "near", "far")


def eyes_of(view: View, eyes: EyesSettings) -> EyesSettings:
    """The eyes with what the view changes of them.

    Raises
    ------
    InputError
        Where a value of the view cannot be.
    """
    changes = {name: getattr(view, name) for name in _PARAMETERS if getattr(view, name) is not None}
    stay = {FOLLOWERS.get(name) for name in changes}.isdisjoint
    values = {name: value for name, value in asdict(eyes).items() if stay({name})}
    try:
        return EyesSettings(**values | changes)
    except ValueError as error:
        raise InputError(f"view with {changes}: {error}") from error


def rig_of(view: View, eyes: EyesSettings) -> StereoRig:
    """The rectified rig that looks at the view's target with disparity 0.

    Principal points are shifted by half the disparity that the target would have: left by -s / 2,
    right by +s / 2, with s = f b / D and D the distance of the target.
    """
    check_finite("view position", view.position)
    check_finite("view target", view.target)
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
    )


def left_pose(view: View, baseline: float) -> Array:
    """`T_world_left` (4, 4): the left eye, half the baseline beside the view's position."""
    T_world_left = look_at(view.position, view.target)
    T_world_left[:3, 3] -= 0.5 * baseline * T_world_left[:3, 0]
    return T_world_left


def eye_camera(T_world_eye: Array, focal_px: float, centre_px: Array, eyes: EyesSettings) -> Camera:
    """Rays of one eye, with the principal point `centre_px` (2,)."""
    right, down, forward = T_world_eye[:3, :3].T
    return Camera(
        width=eyes.width,
        height=eyes.height,
        near=eyes.near,
        far=eyes.far,
        origin=T_world_eye[:3, 3],
        direction=forward - (centre_px[0] * right + centre_px[1] * down) / focal_px,
        steps=np.array([np.zeros(3), right / focal_px, np.zeros(3), down / focal_px]),
    )
