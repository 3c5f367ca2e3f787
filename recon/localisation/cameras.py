"""Cameras: the left camera of a pair as solids are drawn for it."""

import numpy as np
from numpy.typing import NDArray

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


def coloured(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image (H, W, 3), grey or not."""
    return image if image.ndim == 3 else np.repeat(image[:, :, None], 3, axis=2)
