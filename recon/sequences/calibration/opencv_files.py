"""Calibrations saved with OpenCV or ROS: matrices K, D, R, T or P by name."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.geometry import invert, pose
from recon.sequences.calibration.cameras import (
    Calibration,
    Camera,
    from_projections,
    projected_step,
)
from recon.sequences.calibration.documents import Document, numbers, whole
from recon.sequences.calibration.rigid import rigid

Array = NDArray[np.float64]

SIDES = ("left", "right")
_STEMS = {
    "K": r"(?:k|m|a|cameramatrix|camera|intrinsics?|intrinsicmatrix|mtx)",
    "D": r"(?:d|distcoeffs?|distortion|distortioncoefficients|distortioncoeffs|dist)",
    "P": r"(?:p|projection|projectionmatrix|proj)",
}
_STEPS = {
    "R": ("R", "rotation", "rotation_matrix", "Rotation", "rot", "R12"),
    "T": ("T", "translation", "translation_vector", "Translation", "trans", "T12"),
}
_FIELDS = {
    "camera_matrix": "Kk", "distortion_coefficients": "Dd", "rectification_matrix": "Rr",
    "projection_matrix": "Pp",
}  # fmt: skip
LENSES = {
    "plumb_bob": False, "rational_polynomial": False, "radtan": False, "radial-tangential": False,
    "radialtangential": False, "radialtangential8": False, "none": False, "": False,
    "equidistant": True, "fisheye": True, "kannala_brandt4": True,
}  # fmt: skip
"""Distortion models of all tools; true for fisheye models."""


def is_opencv(document: Document) -> bool:
    """True if a document has two cameras by OpenCV's names, or their rectified projections."""
    return any(_named(document, what, side) is not None for what in "KP" for side in SIDES)


def opencv(document: Document) -> Calibration:
    """`stereoCalibrate`'s results K1 D1 K2 D2 R T (M1, cameraMatrix1, ...), or only P1 and P2."""
    if _named(document, "K", "left") is None and _named(document, "P", "left") is not None:
        P_left, P_right = (_projection(document, side) for side in SIDES)
        return from_projections(P_left, P_right, size=image_size(document))
    size = image_size(document)
    cameras = [_camera(document, side, size) for side in SIDES]
    rotation = numbers(_step(document, "R"), (-1,))
    step = numbers(_step(document, "T"), (3,))
    if rotation.size == 3:  # a rotation vector (Rodrigues)
        import cv2

        rotation = cv2.Rodrigues(rotation)[0]
    T_right_left = pose(numbers(rotation, (3, 3)), step)
    return Calibration(left=cameras[0], right=cameras[1], T_right_left=rigid("R", T_right_left))


def _camera(document: Document, side: str, size: tuple[int, int] | None) -> Camera:
    number = 1 + SIDES.index(side)
    matrix = _named(document, "K", side)
    distortion = _named(document, "D", side)
    if matrix is None:
        raise KeyError(f"K{number} or M{number}")
    if distortion is None:
        raise KeyError(f"D{number} or distCoeffs{number}")
    model = str(document.get("distortion_model", "")).lower()
    return Camera(
        matrix=numbers(matrix, (3, 3)),
        distortion=numbers(distortion, (-1,)),
        is_fisheye=LENSES.get(model, False),
        size=size,
    )


def _projection(document: Document, side: str) -> Array:
    value = _named(document, "P", side)
    if value is None:
        raise KeyError(f"P{1 + SIDES.index(side)}")
    return numbers(value, (3, 4))


def _named(document: Document, what: str, side: str) -> Any:
    """The value of a matrix of one side, by any common spelling of its name."""
    plain = {re.sub(r"[^a-z0-9]", "", name.lower()): name for name in document}
    stem = _STEMS[what]
    for own in _spellings(plain, stem, side):
        pattern = re.compile(rf"{stem}{own}|{own}{stem}")
        found = next((name for key, name in plain.items() if pattern.fullmatch(key)), None)
        if found is not None:
            return document[found]
    return None


def _spellings(plain: dict[str, str], stem: str, side: str) -> list[str]:
    """Words that indicate a side; if numbering starts at 0, 1 is the right one."""
    from_zero = any(re.fullmatch(rf"{stem}(cam)?0|(cam)?0{stem}", key) for key in plain)
    if from_zero:
        return [r"(?:cam)?0"] if side == "left" else [r"(?:cam)?1"]
    return [r"(?:1|l|left|cam1)"] if side == "left" else [r"(?:2|r|right|cam2)"]


def _step(document: Document, what: str) -> Any:
    for name in _STEPS[what]:
        if name in document:
            return document[name]
    raise KeyError(what)


def image_size(document: Document) -> tuple[int, int] | None:
    """(width, height) in pixels, None if not stated."""
    for names in (("image_width", "image_height"), ("imageWidth", "imageHeight"),
                  ("Camera.width", "Camera.height"), ("width", "height")):  # fmt: skip
        if all(name in document for name in names):
            return whole(document[names[0]], names[0]), whole(document[names[1]], names[1])
    for name in ("image_size", "imageSize", "image_Size", "ImageSize", "size", "img_size"):
        if name in document:
            width, height = numbers(document[name], (2,))
            return whole(width, name), whole(height, name)
    return None


def named_as_ros(document: Document) -> Document:
    """A CameraInfo message (K D R P; in ROS 2 k d r p) by the names of camera_calibration."""
    if "distortion_model" not in document:
        return document
    fields = {name: key for name in _FIELDS for key in _FIELDS[name] if key in document}
    return {**document, **{name: document[key] for name, key in fields.items()}}


def is_ros(document: Document) -> bool:
    """True if a document is one camera of ROS camera_calibration."""
    return "camera_matrix" in document and "projection_matrix" in document


def ros(left: Document, right: Document) -> Calibration:
    """The rig from the two ROS camera files, for raw images.

    The baseline is in the right projection; R rotates each raw camera to the rectified one.
    """
    cameras = [_ros_camera(document) for document in (left, right)]
    P_left, P_right = (numbers(one["projection_matrix"], (3, 4)) for one in (left, right))
    R_left, R_right = (numbers(one["rectification_matrix"], (3, 3)) for one in (left, right))
    return from_rectified(cameras, (P_left, P_right), (R_left, R_right))


def from_rectified(
    cameras: list[Camera], projections: tuple[Array, Array], rotations: tuple[Array, Array]
) -> Calibration:
    """Raw cameras from their rectified projections and the `rotations` to the rectified frames."""
    step = projected_step(projections[1]) - projected_step(projections[0])
    T_rectified_left, T_rectified_right = (
        rigid("the rectification matrix", pose(R, np.zeros(3))) for R in rotations
    )
    return Calibration(
        left=cameras[0],
        right=cameras[1],
        T_right_left=invert(T_rectified_right) @ pose(np.eye(3), step) @ T_rectified_left,
    )


def _ros_camera(document: Document) -> Camera:
    model = str(document.get("distortion_model", ""))
    if model.lower() not in LENSES:
        raise ValueError(f"distortion model {model:.40} is not known")
    return Camera(
        matrix=numbers(document["camera_matrix"], (3, 3)),
        distortion=numbers(document.get("distortion_coefficients", []), (-1,)),
        is_fisheye=LENSES[model.lower()],
        size=image_size(document),
    )
