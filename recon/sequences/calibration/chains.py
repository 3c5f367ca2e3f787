"""Calibrations of visual odometry tools: Kalibr, EuRoC, OKVIS, VINS-Fusion, ORB-SLAM."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert, pose
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.documents import Document, numbers, read_document, whole
from recon.sequences.calibration.opencv_files import LENSES, from_rectified, image_size
from recon.sequences.calibration.rigid import rigid

Array = NDArray[np.float64]


def is_kalibr(document: Document) -> bool:
    """True if a document is a camera chain of Kalibr (also used by OpenVINS)."""
    return "cam0" in document and "cam0_calib" not in document


def kalibr(document: Document) -> Calibration:
    """cam0 and cam1, with their relative pose given directly or through the IMU."""
    sides = [_mapping(document, name) for name in ("cam0", "cam1")]
    left, right = (_camera(side, "distortion_coeffs") for side in sides)
    return Calibration(left=left, right=right, T_right_left=_kalibr_step(*sides))


def _kalibr_step(left: Document, right: Document) -> Array:
    if "T_cn_cnm1" in right:
        return _motion(right, "T_cn_cnm1")
    if "T_cam_imu" in left and "T_cam_imu" in right:
        return _motion(right, "T_cam_imu") @ invert(_motion(left, "T_cam_imu"))
    for name in ("T_imu_cam", "T_BS", "T_body_cam"):
        if name in left and name in right:
            return invert(_motion(right, name)) @ _motion(left, name)
    raise KeyError("T_cn_cnm1, T_cam_imu or T_imu_cam of cam1")


def read_sensors(left_path: Path, right_path: Path) -> tuple[Calibration, Array]:
    """The rig from EuRoC's two sensor.yaml, and `T_body_left` (4, 4)."""
    left, right = read_document(left_path), read_document(right_path)
    try:
        T_body_left, T_body_right = (_motion(document, "T_BS") for document in (left, right))
        cameras = [_camera(document, "distortion_coefficients") for document in (left, right)]
    except KeyError as error:
        raise InputError(f"{left_path} or {right_path} lacks {error.args[0]}") from error
    except (ValueError, TypeError) as error:
        raise InputError(f"{left_path} or {right_path}: {error}") from error
    T_right_left = invert(T_body_right) @ T_body_left
    rig = Calibration(left=cameras[0], right=cameras[1], T_right_left=T_right_left)
    return rig, T_body_left


def is_okvis(document: Document) -> bool:
    """True if a document is an OKVIS configuration."""
    return isinstance(document.get("cameras"), list)


def okvis(document: Document) -> Calibration:
    """The first two `cameras`, each with its pose T_SC on the sensor."""
    listed = document["cameras"]
    if len(listed) < 2 or not all(isinstance(one, dict) for one in listed[:2]):
        raise ValueError(f"there are {len(listed)} cameras, but two are needed")
    T_sensor_left, T_sensor_right = (_motion(one, "T_SC") for one in listed[:2])
    left, right = (_okvis_camera(one) for one in listed[:2])
    return Calibration(left=left, right=right, T_right_left=invert(T_sensor_right) @ T_sensor_left)


def _okvis_camera(document: Document) -> Camera:
    width, height = numbers(document["image_dimension"], (2,))
    return pinhole(
        [*numbers(document["focal_length"], (2,)), *numbers(document["principal_point"], (2,))],
        numbers(document.get("distortion_coefficients", []), (-1,)),
        str(document.get("distortion_type", "none")),
        (whole(width, "image_dimension"), whole(height, "image_dimension")),
    )


def is_vins(document: Document) -> bool:
    """True if a document is a stereo configuration of VINS-Fusion."""
    return "cam0_calib" in document


def vins(document: Document, folder: Path) -> Calibration:
    """`body_T_cam0`, `body_T_cam1`, and the cameras in separate files."""
    T_body_left, T_body_right = (_motion(document, f"body_T_cam{side}") for side in (0, 1))
    left, right = (_vins_camera(_beside(document, f"cam{side}_calib", folder)) for side in (0, 1))
    return Calibration(left=left, right=right, T_right_left=invert(T_body_right) @ T_body_left)


def _beside(document: Document, name: str, folder: Path) -> Document:
    if name not in document:
        raise KeyError(name)
    path = folder / str(document[name])
    if not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{name} is {document[name]!s:.60}, which is outside its folder")
    return read_document(path)


def _vins_camera(document: Document) -> Camera:
    model, values = str(document.get("model_type", "")), _mapping(document, "projection_parameters")
    if model == "PINHOLE":
        lens = _mapping(document, "distortion_parameters")
        distortion = np.array([_number(lens, name) for name in ("k1", "k2", "p1", "p2")])
        focal = [_number(values, name) for name in ("fx", "fy", "cx", "cy")]
    elif model == "KANNALA_BRANDT":
        distortion = np.array([_number(values, name) for name in ("k2", "k3", "k4", "k5")])
        focal = [_number(values, name) for name in ("mu", "mv", "u0", "v0")]
    else:
        raise _unknown(model)
    lens_name = "none" if model == "PINHOLE" else "equidistant"
    return pinhole(focal, distortion, lens_name, image_size(document))


def is_orbslam(document: Document) -> bool:
    """True if a document contains settings of ORB-SLAM 2 or 3."""
    return any(name in document for name in ("Camera.fx", "Camera1.fx"))


def orbslam(document: Document) -> Calibration:
    """Stereo cameras of ORB-SLAM: rectified with Camera.bf or Stereo.b, or raw with their pose."""
    if "LEFT.K" in document:
        return _orbslam2_raw(document)
    second = "Camera2.fx" in document
    first = "Camera1" if "Camera1.fx" in document else "Camera"
    left = _orbslam_camera(document, first)
    right = _orbslam_camera(document, "Camera2") if second else left
    return Calibration(left=left, right=right, T_right_left=_orbslam_step(document, left))


def _orbslam_step(document: Document, left: Camera) -> Array:
    for name in ("Stereo.T_c1_c2", "Tlr"):
        if name in document:
            rows = numbers(document[name], (-1, 4))[:3]
            return invert(rigid(name, np.vstack([rows, [0.0, 0.0, 0.0, 1.0]])))
    if "Stereo.b" in document:
        return pose(np.eye(3), [-_number(document, "Stereo.b"), 0.0, 0.0])
    if "Camera.bf" in document:
        return pose(np.eye(3), [-_number(document, "Camera.bf") / left.matrix[0, 0], 0.0, 0.0])
    raise KeyError("Stereo.T_c1_c2, Stereo.b or Camera.bf")


def _orbslam_camera(document: Document, name: str) -> Camera:
    model = str(document.get("Camera.type", "PinHole"))
    if model not in ("PinHole", "Rectified", "KannalaBrandt8"):
        raise _unknown(model)
    focal = [_number(document, f"{name}.{key}") for key in ("fx", "fy", "cx", "cy")]
    lens = "equidistant" if model == "KannalaBrandt8" else "none"
    keys = ("k1", "k2", "k3", "k4") if lens == "equidistant" else ("k1", "k2", "p1", "p2", "k3")
    given = [_number(document, f"{name}.{key}", 0.0) for key in keys]
    distortion = np.array(given if any(given) else [])
    return pinhole(focal, distortion, lens, image_size(document))


def _orbslam2_raw(document: Document) -> Calibration:
    cameras = [
        Camera(
            matrix=numbers(document[f"{side}.K"], (3, 3)),
            distortion=numbers(document[f"{side}.D"], (-1,)),
            size=(
                whole(document[f"{side}.width"], f"{side}.width"),
                whole(document[f"{side}.height"], f"{side}.height"),
            ),
        )
        for side in ("LEFT", "RIGHT")
    ]
    projections = [numbers(document[f"{side}.P"], (3, 4)) for side in ("LEFT", "RIGHT")]
    rotations = [numbers(document[f"{side}.R"], (3, 3)) for side in ("LEFT", "RIGHT")]
    return from_rectified(cameras, (projections[0], projections[1]), (rotations[0], rotations[1]))


def _unknown(model: str) -> ValueError:
    """The error of a camera that neither OpenCV nor recon can rectify."""
    return ValueError(
        f"camera model {model:.40} is not known: calibrate again as pinhole with radtan or, for "
        "wide lenses, equidistant distortion (Kalibr: pinhole-equi), or give rectified images"
    )


def pinhole(focal: Any, distortion: Array, lens: str, size: tuple[int, int] | None) -> Camera:
    """A camera from fx, fy, cx, cy and a distortion model by any tool's name."""
    if lens.lower() not in LENSES:
        raise _unknown(f"pinhole with {lens}")
    fx, fy, cx, cy = (float(value) for value in focal)
    return Camera(
        matrix=np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        distortion=distortion,
        is_fisheye=LENSES[lens.lower()],
        size=size,
    )


def _camera(document: Document, distortion: str) -> Camera:
    """A pinhole camera from Kalibr's or EuRoC's keys."""
    model = document.get("camera_model", "pinhole")
    lens = str(document.get("distortion_model", "none"))
    if model != "pinhole":
        raise _unknown(f"{model} with {lens}")
    width, height = numbers(document["resolution"], (2,))
    return pinhole(
        numbers(document["intrinsics"], (4,)),
        numbers(document.get(distortion, []), (-1,)),
        lens,
        (whole(width, "resolution"), whole(height, "resolution")),
    )


def _motion(document: Document, name: str) -> Array:
    return rigid(name, numbers(document[name], (4, 4)))


def _mapping(document: Document, name: str) -> Document:
    value = document[name]
    if not isinstance(value, dict):
        raise ValueError(f"{name} is a {type(value).__name__}, but keys are needed")
    return value


def _number(document: Document, name: str, default: float | None = None) -> float:
    if name not in document and default is not None:
        return default
    return float(numbers(document[name], (1,))[0])
