"""Poses by image name, as in COLMAP and nerfstudio."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.errors import InputError
from recon.files import atomic_path
from recon.files.documents import read_json
from recon.geometry import invert, pose
from recon.sequences.calibration.rigid import made_rigid, say_rigid
from recon.sequences.poses import GivenPoses
from recon.sequences.text import is_finite

Array = NDArray[np.float64]

COLMAP_COLUMNS = 10
"""IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"""
OPENCV_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
"""nerfstudio's cameras look along -z, y up."""


def is_colmap(lines: Sequence[str]) -> bool:
    """True if the first row is a COLMAP image: nine numbers and a name."""
    first = next((line for line in lines if line.strip() and line[0] != "#"), "").split()
    return (
        len(first) >= COLMAP_COLUMNS
        and all(is_finite(field) for field in first[:9])
        and not is_finite(first[9])
    )


def read_colmap(path: Path, lines: Sequence[str]) -> GivenPoses:
    """The images of COLMAP's images.txt: world to camera; every second row lists their points.

    Raises
    ------
    InputError
        With the line that is not an image.
    """
    rows = [(number, line) for number, line in enumerate(lines, start=1) if line[:1] != "#"]
    names, poses = [], []
    for number, line in rows[::2]:
        fields = line.split(maxsplit=COLMAP_COLUMNS - 1)
        if not fields:
            continue
        if len(fields) < COLMAP_COLUMNS or not all(is_finite(field) for field in fields[:9]):
            raise InputError(f"{path}, line {number}: {line[:60]!r} is not a COLMAP image")
        w, x, y, z, *step = (float(field) for field in fields[1:8])
        if not 0.9 < math.hypot(w, x, y, z) < 1.1:
            raise InputError(f"{path}, line {number}: its quaternion does not have length 1")
        poses.append(invert(pose(Rotation.from_quat([x, y, z, w]).as_matrix(), step)))
        names.append(fields[9].strip())
    return _sorted(names, poses)


def read_nerfstudio(path: Path) -> GivenPoses:
    """The frames of transforms.json: camera to world, cameras as in OpenGL.

    Raises
    ------
    InputError
        If a frame lacks its file or its matrix.
    """
    document = read_json(path)
    frames = document.get("frames") if isinstance(document, dict) else None
    if not isinstance(frames, list) or not frames:
        raise InputError(f"{path} has no frames, but those of nerfstudio are needed")
    names, poses, errors = [], [], []
    for number, frame in enumerate(frames):
        name, T_world_gl = _nerfstudio_frame(path, number, frame)
        exact, error = made_rigid(f"{path}: the pose of frame {number}", T_world_gl)
        names.append(name)
        poses.append(exact @ OPENCV_OPENGL)
        errors.append(error)
    say_rigid(f"{path}: the pose of frame {int(np.argmax(errors))}", max(errors))
    return _sorted(names, poses)


def _nerfstudio_frame(path: Path, number: int, frame: Any) -> tuple[str, Array]:
    try:
        T_world_gl = np.array(frame["transform_matrix"], dtype=np.float64).reshape(-1, 4)[:3]
        if T_world_gl.shape != (3, 4) or not np.isfinite(T_world_gl).all():
            raise ValueError("3 or 4 rows of 4 finite numbers are needed")
        return str(frame["file_path"]), pose(T_world_gl[:, :3], T_world_gl[:, 3])
    except (KeyError, TypeError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"{path}: frame {number} has no file_path and transform_matrix ({reason:.60})"
        ) from error


def _sorted(names: list[str], poses: list[Array]) -> GivenPoses:
    """Poses sorted by name; the first one defines what is up."""
    if not names:
        raise InputError("the file contains no pose")
    order = sorted(range(len(names)), key=lambda row: names[row])
    return GivenPoses(
        poses=np.stack([poses[row] for row in order]), names=tuple(names[row] for row in order)
    )


def write_colmap(
    folder: Path, names: Sequence[str], T_world_left: Array, rigs: Sequence[StereoRig]
) -> None:
    """Write images.txt, cameras.txt and an empty points3D.txt of left cameras (N, 4, 4).

    COLMAP puts pixel (0, 0) at the CORNER of the top-left pixel: half a pixel is added.
    """
    numbers = {rig: number for number, rig in enumerate(dict.fromkeys(rigs), start=1)}
    cameras = [
        f"{number} PINHOLE {rig.width} {rig.height} {rig.focal_px!r} {rig.focal_px!r} "
        f"{rig.cx_left_px + 0.5!r} {rig.cy_px + 0.5!r}\n"
        for rig, number in numbers.items()
    ]
    rows = []
    for number, (name, T, rig) in enumerate(zip(names, T_world_left, rigs, strict=True), start=1):
        T_left_world = invert(T)
        x, y, z, w = Rotation.from_matrix(T_left_world[:3, :3]).as_quat()
        values = " ".join(repr(float(v)) for v in (w, x, y, z, *T_left_world[:3, 3]))
        rows.append(f"{number} {values} {numbers[rig]} {name}\n\n")
    folder.mkdir(parents=True, exist_ok=True)
    heading = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then the points of the image\n"
    for file, text in (
        ("cameras.txt", "# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY\n" + "".join(cameras)),
        ("images.txt", heading + "".join(rows)),
        ("points3D.txt", "# POINT3D_ID X Y Z R G B ERROR TRACK\n"),
    ):
        with atomic_path(folder / file) as temporary:
            temporary.write_text(text, encoding="utf-8")


def write_nerfstudio(
    path: Path, names: Sequence[str], T_world_left: Array, rigs: Sequence[StereoRig]
) -> None:
    """Write transforms.json of left cameras (N, 4, 4); pixel (0, 0) is a corner there.

    Intrinsics that differ between frames are stored per frame.
    """
    is_one = len(set(rigs)) == 1
    document = {
        "camera_model": "OPENCV",
        **(_intrinsics(rigs[0]) if is_one else {}),
        "frames": [
            {"file_path": name, "transform_matrix": (T @ OPENCV_OPENGL).tolist()}
            | ({} if is_one else _intrinsics(rig))
            for name, T, rig in zip(names, T_world_left, rigs, strict=True)
        ],
    }
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(document, indent=2), encoding="utf-8")


def _intrinsics(rig: StereoRig) -> dict[str, float]:
    """Intrinsics of the left camera, by nerfstudio's keys."""
    return {
        "w": rig.width, "h": rig.height, "fl_x": rig.focal_px, "fl_y": rig.focal_px,
        "cx": rig.cx_left_px + 0.5, "cy": rig.cy_px + 0.5,
    }  # fmt: skip
