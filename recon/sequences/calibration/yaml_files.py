"""Calibrations in YAML: OpenCV's, Kalibr's camera chain, EuRoC's sensor files."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert, pose
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.poses import exact, read_lines

Array = NDArray[np.float64]
Document = Mapping[str, Any]

MODELS = {"radtan": False, "radial-tangential": False, "none": False, "plumb_bob": False,
          "equidistant": True}  # fmt: skip
"""Distortion models, and whether they are a fisheye's."""

NAMES = {
    "K": ("K{0}", "M{0}", "cameraMatrix{0}", "camera_matrix_{0}", "CameraMatrix{0}"),
    "D": ("D{0}", "distCoeffs{0}", "dist_coeffs_{0}", "distortion_{0}", "DistCoeffs{0}"),
}
"""What OpenCV's users call the matrix and the distortion of camera 1 (left) and 2 (right)."""


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML ships no types
    """Plain YAML and OpenCV's two kinds of matrix."""


def _matrix_node(loader: _Loader, node: yaml.MappingNode) -> Array:
    fields = loader.construct_mapping(node, deep=True)
    shape = fields.get("sizes") or (fields["rows"], fields["cols"])
    return np.array([float(value) for value in fields["data"]]).reshape(shape)


for _name in ("opencv-matrix", "opencv-nd-matrix"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_name}", _matrix_node)


def read_yaml(path: Path) -> Document:
    """The keys of a YAML file, OpenCV's header of 4.x (no YAML) and 5 included.

    Raises
    ------
    InputError
        With the line that is no YAML.
    """
    lines = read_lines(path)
    text = "\n".join("" if re.match(r"%YAML|---\s*$", line) else line for line in lines)
    try:
        document = yaml.load(text, _Loader)  # a SafeLoader: nothing is run
    except (yaml.YAMLError, KeyError, ValueError, TypeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}{line}: this is no calibration in YAML") from error
    if not isinstance(document, dict):
        raise InputError(f"{path} holds no keys, but a calibration is needed")
    return document


def read_yaml_calibration(path: Path) -> Calibration:
    """Two cameras of OpenCV's or Kalibr's YAML, told apart by their keys."""
    document = read_yaml(path)
    try:
        if "cam0" in document:
            return _kalibr(document)
        return _opencv(document)
    except KeyError as error:
        raise InputError(f"{path} lacks {error.args[0]}") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from error


def _opencv(document: Document) -> Calibration:
    """`stereoCalibrate`'s results: K1 D1 K2 D2 R T (or M1, cameraMatrix1, ...)."""
    size = _opencv_size(document)
    cameras = [
        Camera(
            matrix=_numbers(_named(document, "K", side), (3, 3)),
            distortion=_numbers(_named(document, "D", side), (-1,)),
            size=size,
        )
        for side in (1, 2)
    ]
    rotation, step = _numbers(document["R"], (3, 3)), _numbers(document["T"], (3,))
    return Calibration(left=cameras[0], right=cameras[1], T_right_left=pose(rotation, step))


def _named(document: Document, what: str, side: int) -> Any:
    names = [name.format(side) for name in NAMES[what]]
    found = next((name for name in names if name in document), None)
    if found is None:
        raise KeyError(" or ".join(names))
    return document[found]


def _opencv_size(document: Document) -> tuple[int, int] | None:
    if "image_width" in document and "image_height" in document:
        return int(document["image_width"]), int(document["image_height"])
    for name in ("image_size", "imageSize", "size"):
        if name in document:
            width, height = _numbers(document[name], (2,))
            return int(width), int(height)
    return None


def _kalibr(document: Document) -> Calibration:
    left, right = (_camera(document[name], "distortion_coeffs") for name in ("cam0", "cam1"))
    return Calibration(
        left=left,
        right=right,
        T_right_left=exact("T_cn_cnm1", _numbers(document["cam1"]["T_cn_cnm1"], (4, 4))),
    )


def read_sensors(left_path: Path, right_path: Path) -> tuple[Calibration, Array]:
    """The rig of EuRoC's two sensor.yaml, and `T_body_left` (4, 4)."""
    left, right = read_yaml(left_path), read_yaml(right_path)
    try:
        T_body_left, T_body_right = (
            exact("T_BS", _numbers(document["T_BS"], (4, 4))) for document in (left, right)
        )
        cameras = [_camera(document, "distortion_coefficients") for document in (left, right)]
    except KeyError as error:
        raise InputError(f"{left_path} or {right_path} lacks {error.args[0]}") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{left_path} or {right_path}: {error}") from error
    T_right_left = invert(T_body_right) @ T_body_left
    rig = Calibration(left=cameras[0], right=cameras[1], T_right_left=T_right_left)
    return rig, T_body_left


def _camera(document: Document, distortion: str) -> Camera:
    """A pinhole camera of Kalibr's or EuRoC's keys."""
    model = document.get("camera_model", "pinhole")
    lens = document.get("distortion_model", "none")
    if model != "pinhole" or lens not in MODELS:
        raise ValueError(f"camera model {model} with {lens} is not known")
    fx, fy, cx, cy = _numbers(document["intrinsics"], (4,))
    width, height = (int(value) for value in document["resolution"])
    return Camera(
        matrix=np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        distortion=_numbers(document.get(distortion, []), (-1,)),
        is_fisheye=MODELS[lens],
        size=(width, height),
    )


def _numbers(value: Any, shape: tuple[int, ...]) -> Array:
    """A matrix however it is written: OpenCV's, rows of rows, or {rows, cols, data}."""
    data = value["data"] if isinstance(value, dict) else value
    try:
        return np.array(data, dtype=np.float64).reshape(shape)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{value!s:.60} is not {shape} numbers") from error
