"""Images and cameras as ROS 1 and 2 write them."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert, pose
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.files import from_projections
from recon.sequences.images import Image, decode

BAYER = {
    "bayer_rggb8": cv2.COLOR_BayerRGGB2RGB,
    "bayer_bggr8": cv2.COLOR_BayerBGGR2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGBRG2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGRBG2RGB,
}
CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "8UC3": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4}
"""Encodings of one byte a channel."""

IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
CAMERA_TYPE = "sensor_msgs/msg/CameraInfo"


def stamp_ns(message: Any) -> int:
    """When a message was taken, by its header."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def image(message: Any) -> Image:
    """The image of an Image or CompressedImage, grey or RGB.

    Raises
    ------
    InputError
        Where its encoding is not known or its bytes do not fit its size.
    """
    data = np.asarray(message.data, dtype=np.uint8)
    if hasattr(message, "format"):
        return decode(data.tobytes(), "its compressed image")
    if message.encoding == "mono16":
        return _deep(message, data)
    channels = 1 if message.encoding in BAYER else CHANNELS.get(message.encoding)
    if channels is None:
        raise InputError(f"its image is encoded as {message.encoding!r}, which is not known")
    return _to_rgb(_pixels(message, data, channels), message.encoding)


def _pixels(message: Any, data: NDArray[np.uint8], num_bytes: int) -> Image:
    """(H, W, num_bytes) without what pads the rows."""
    if data.size != message.height * message.step or message.step < message.width * num_bytes:
        raise InputError(
            f"its image has {data.size} bytes, which are not {message.height} rows of "
            f"{message.width} pixels"
        )
    rows = data.reshape(message.height, message.step)[:, : message.width * num_bytes]
    return rows.reshape(message.height, message.width, num_bytes)


def _deep(message: Any, data: NDArray[np.uint8]) -> Image:
    """The upper byte of each pixel of 16 bits."""
    return np.ascontiguousarray(_pixels(message, data, 2)[..., 0 if message.is_bigendian else 1])


def _to_rgb(pixels: Image, encoding: str) -> Image:
    if encoding in BAYER:
        colour: Image = cv2.cvtColor(pixels[..., 0], BAYER[encoding])
        return colour
    if pixels.shape[2] == 1:
        return np.ascontiguousarray(pixels[..., 0])
    order = slice(2, None, -1) if encoding.startswith("bgr") else slice(0, 3)
    return np.ascontiguousarray(pixels[..., order])


def calibration_of(left: Any, right: Any, *, is_rectified: bool) -> Calibration:
    """The rig of two CameraInfo messages, for rectified images or for raw ones.

    The step between the cameras is in the right projection; raw cameras are turned from the
    rectified ones by their own R.
    """
    P_left, P_right = (_field(info, "P").reshape(3, 4) for info in (left, right))
    if not (P_left[0, 0] > 0 and P_right[0, 0] > 0):
        raise InputError("the camera info of the bag is empty, but a projection is needed")
    if is_rectified:
        return from_projections(P_left, P_right)
    step = np.linalg.solve(P_right[:, :3], P_right[:, 3])
    T_rectified_left, T_rectified_right = (
        pose(_field(info, "R").reshape(3, 3), np.zeros(3)) for info in (left, right)
    )
    return Calibration(
        left=_camera(left),
        right=_camera(right),
        T_right_left=invert(T_rectified_right) @ pose(np.eye(3), step) @ T_rectified_left,
    )


def _field(info: Any, name: str) -> NDArray[np.float64]:
    """A matrix; ROS 1 writes its name large, ROS 2 small."""
    return np.asarray(getattr(info, name if hasattr(info, name) else name.lower()), np.float64)


def _camera(info: Any) -> Camera:
    return Camera(
        matrix=_field(info, "K").reshape(3, 3),
        distortion=_field(info, "D"),
        is_fisheye=info.distortion_model == "equidistant",
        size=(int(info.width), int(info.height)),
    )
