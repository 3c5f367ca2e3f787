"""Images and cameras in ROS 1 and 2 messages."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.libraries import load_extra
from recon.sequences.calibration.cameras import Calibration, Camera, from_projections
from recon.sequences.calibration.opencv_files import LENSES, from_rectified
from recon.sequences.depth import Pixels
from recon.sequences.images import decode_pixels, masked

PLAIN = {"8UC1": "mono8", "8UC3": "bgr8", "8UC4": "bgra8", "16UC1": "mono16", "16UC3": "bgr16"}
"""OpenCV encodings, which do not name the colours, in OpenCV's channel order."""
_PNG_START = b"\x89PNG"
DEPTH_HEADER_BYTES = 64
"""compressedDepth has some parameters before the PNG."""

IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
CAMERA_TYPE = "sensor_msgs/msg/CameraInfo"


def stamp_ns(message: Any) -> int:
    """The time in the header of a message; 0 if not set."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def image(message: Any) -> Pixels:
    """The image of an Image or CompressedImage, grey or RGB, 8 or 16 bits.

    Raises
    ------
    InputError
        If its encoding is unknown or its bytes do not fit its size.
    """
    data = np.asarray(message.data, dtype=np.uint8)
    if hasattr(message, "format"):
        return _compressed(data.tobytes())
    encoding = PLAIN.get(message.encoding, message.encoding)
    library = load_extra("rosbags.image.image", "ros")
    try:
        _, _, kind, channels = library.to_cvtype(encoding)
        pixels = _pixels(message, data, np.dtype(kind), channels)
        return masked(_in_rgb(library, pixels, encoding))
    except library.ImageError as error:
        raise InputError(
            f"its image is encoded as {message.encoding!r:.40}, which is not known"
        ) from error


def _compressed(data: bytes) -> Pixels:
    start = data.find(_PNG_START, 0, DEPTH_HEADER_BYTES)
    return decode_pixels(data[max(0, start) :], "its compressed image")


def _pixels(message: Any, data: NDArray[np.uint8], kind: np.dtype[Any], channels: int) -> Pixels:
    """(H, W) or (H, W, channels) without row padding."""
    num_bytes = message.width * channels * kind.itemsize
    if data.size != message.height * message.step or message.step < num_bytes or not num_bytes:
        raise InputError(
            f"its image has {data.size} bytes, which are not {message.height} rows of "
            f"{message.width} pixels"
        )
    rows = np.ascontiguousarray(data.reshape(message.height, message.step)[:, :num_bytes])
    values = rows.view(kind.newbyteorder(">" if message.is_bigendian else "<")).astype(kind)
    shape = (message.height, message.width, channels)
    return values.reshape(shape if channels > 1 else shape[:2])


def _in_rgb(library: Any, pixels: Pixels, encoding: str) -> Pixels:
    """Grey unchanged, all colours as RGB, alpha kept."""
    if encoding.startswith("mono"):
        return pixels
    wanted = "rgba" if "a8" in encoding or "a16" in encoding else "rgb"
    depth = "16" if pixels.dtype == np.uint16 else "8"
    rgb: Pixels = library.convert_color(pixels, encoding, wanted + depth)
    return rgb


def calibration_of(left: Any, right: Any, *, is_rectified: bool) -> Calibration:
    """The rig from two CameraInfo messages, for rectified or raw images.

    The baseline is in the right projection; R rotates each raw camera to the rectified one.
    """
    P_left, P_right = (_field(info, "P").reshape(3, 4) for info in (left, right))
    if not (P_left[0, 0] > 0 and P_right[0, 0] > 0):
        raise InputError("the camera info of the bag is empty, but a projection is needed")
    if is_rectified:
        return from_projections(P_left, P_right)
    R_left, R_right = (_field(info, "R").reshape(3, 3) for info in (left, right))
    cameras = [_camera(info) for info in (left, right)]
    return from_rectified(cameras, (P_left, P_right), (R_left, R_right))


def _field(info: Any, name: str) -> NDArray[np.float64]:
    """A matrix; its name is upper case in ROS 1 and lower case in ROS 2."""
    return np.asarray(getattr(info, name if hasattr(info, name) else name.lower()), np.float64)


def _camera(info: Any) -> Camera:
    return Camera(
        matrix=_field(info, "K").reshape(3, 3),
        distortion=_field(info, "D"),
        is_fisheye=LENSES.get(info.distortion_model, False),
        size=(int(info.width), int(info.height)),
    )
