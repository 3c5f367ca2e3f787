"""Cameras of a run or a recording for COLMAP (images.txt) and nerfstudio (transforms.json)."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.files import check_target
from recon.files.documents import read_text
from recon.geometry import Array
from recon.manifest import MANIFEST
from recon.notices import collected_notices
from recon.records import Trajectory
from recon.runs.cameras import CAMERAS, SeenCamera, read_cameras
from recon.sequences.open import open_sequence
from recon.sequences.posed_images import write_colmap, write_nerfstudio
from recon.settings import SequenceSettings

COLMAP, NERFSTUDIO = "images.txt", "transforms.json"
POSED = (COLMAP, NERFSTUDIO)
"""Names of files with poses of images."""


def export_poses(source: Path, target: Path, *, overwrite: bool = False) -> dict[str, Any]:
    """Write poses and intrinsics of the rectified left images of a run or a recording.

    COLMAP's cameras.txt and points3D.txt are written beside its images.txt.

    Returns
    -------
    dict
        The document of `recon export --json`.
    """
    check_target(target, overwrite=overwrite, may_be_folder=True)  # its folder is made
    with collected_notices() as notices:
        is_run = (source / MANIFEST).is_file()
        seen, poses = _of_run(source) if is_run else _of_recording(source)
    names = [f"left/{one.name}.png" for one in seen]
    rigs = [one.rig for one in seen]
    if target.name == COLMAP:
        write_colmap(target.parent, names, poses, rigs)
    else:
        write_nerfstudio(target, names, poses, rigs)
    return {
        "output": str(target),
        "up": "y",
        "bytes": target.stat().st_size,
        "num_poses": len(names),
        "warnings": [notice.as_json() for notice in notices],
    }


def _of_recording(path: Path) -> tuple[list[SeenCamera], Array]:
    """The cameras of a recording, and `T_world_left` (N, 4, 4)."""
    seen, poses = [], []
    for pair in open_sequence(path, SequenceSettings()):
        seen.append(SeenCamera(name=pair.name, rig=pair.rig))
        poses.append(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
    return seen, np.array(poses)


def _of_run(path: Path) -> tuple[list[SeenCamera], Array]:
    """The same for a run, with its given, estimated or simulated poses."""
    if not (path / "trajectory.txt").is_file():
        raise InputError(f"{path} has no trajectory.txt, but the poses of a run are needed")
    poses = Trajectory.from_tum(read_text(path / "trajectory.txt"), str(path)).T_world_left
    seen = read_cameras(path / CAMERAS)
    if len(seen) != len(poses):
        raise InputError(f"{path} has {len(seen)} cameras, but {len(poses)} poses")
    return seen, poses
