"""KITTI odometry: image_0/image_1 (grey), image_2/image_3 (colour) or image_l/image_r."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import pose
from recon.sequences.calibration.files import from_projections, kitti_projections
from recon.sequences.frames import Recording
from recon.sequences.listing import list_pairs
from recon.sequences.readers.folder import file_recording, given_trajectory
from recon.sequences.timestamps import list_moments, read_times
from recon.settings import SequenceSettings

FOLDERS = (("image_2", "image_3"), ("image_0", "image_1"), ("image_l", "image_r"))
"""Colour before grey."""


def is_kitti(path: Path) -> bool:
    """Whether `path` holds the image folders of a KITTI sequence."""
    return any(all((path / side).is_dir() for side in pair) for pair in FOLDERS)


def open_kitti(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`; its poses are camera 0's, and lead on to the left camera used."""
    sides = next((p for p in FOLDERS if all((path / side).is_dir() for side in p)), None)
    if sides is None:
        raise InputError(f"{path} holds neither of {', '.join(map(' and '.join, FOLDERS))}")
    listed = list_pairs(path / sides[0], path / sides[1])
    P_left, P_right = _projections(path / "calib.txt", sides)
    trajectory = given_trajectory(_poses_path(path), settings)
    moments = list_moments(
        [entry.name for entry in listed],
        read_times(path / "times.txt"),
        trajectory and trajectory.of(_T_camera0_left(P_left)),
        needs_pose=settings.poses == "given",
    )
    return file_recording(listed, moments, from_projections(P_left, P_right), settings)


def _projections(
    path: Path, sides: tuple[str, str]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The two cameras' rows by their number, else the first two."""
    rows = kitti_projections(path)
    labels = [side.replace("image_", "P") for side in sides]
    left, right = labels if all(label in rows for label in labels) else [*rows][:2]
    return rows[left], rows[right]


def _T_camera0_left(P_left: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where the left camera stands in the frame of camera 0, by its projection ``K [I | t]``."""
    return pose(np.eye(3), -np.linalg.solve(P_left[:, :3], P_left[:, 3]))


def _poses_path(path: Path) -> Path:
    """poses.txt of the sequence, or where KITTI keeps it: ../../poses/NAME.txt."""
    beside = path / "poses.txt"
    archive = path.resolve().parent.parent / "poses" / f"{path.resolve().name}.txt"
    return archive if archive.is_file() and not beside.is_file() else beside
