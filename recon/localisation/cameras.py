"""Cameras: the left camera of a pair as solids are drawn for it."""

import numpy as np

from recon.camera import StereoRig
from recon.geometry import Array
from recon.localisation.drawing import Camera


def camera_of(T_world_left: Array, rig: StereoRig) -> Camera:
    """The left camera of a rig at a pose."""
    return Camera(
        turn=np.ascontiguousarray(T_world_left[:3, :3]),
        eye=np.ascontiguousarray(T_world_left[:3, 3]),
        focal_px=rig.focal_px, cx_px=rig.cx_left_px, cy_px=rig.cy_px,
        width=rig.width, height=rig.height,
    )  # fmt: skip
