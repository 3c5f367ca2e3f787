"""A plain folder: left/ and right/, a calibration, and optional poses.txt and times.txt."""

import logging
from collections.abc import Sequence
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.depth import Pixels, Stretch, stretch_of
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.images import ENDINGS, read_image, read_pixels
from recon.sequences.listing import Listed, gaps, list_pairs
from recon.sequences.pose_files import read_poses
from recon.sequences.poses import GivenPoses
from recon.sequences.readers.reader import Reader
from recon.sequences.timestamps import FramePose, list_frame_poses, read_times
from recon.settings import SequenceSettings

log = logging.getLogger(__name__)

SIDES = (("left", "right"), ("Left", "Right"), ("cam0", "cam1"), ("infra1", "infra2"))
"""Names of the folders of both sides."""
TIMES = ("times.txt", "timestamps.txt")
POSES = ("poses.txt", "poses.csv", "groundtruth.txt", "transforms.json", "images.txt")
"""Names of pose files: KITTI's and TUM's, EuRoC's, TUM's, nerfstudio's and COLMAP's."""
NUM_FIRST = 10
"""Number of first frames from which the levels of all are estimated."""


def is_folder(path: Path) -> bool:
    """True if `path` contains left/ and right/, or images in folders of similar names."""
    return _sides(path) is not None


def _sides(path: Path) -> tuple[Path, Path] | None:
    """The folders of the left and the right images; None if there are none."""
    for names in SIDES:
        left, right = (path / name for name in names)
        if left.is_dir() and right.is_dir() and (names == SIDES[0] or _holds_images(left)):
            return left, right
    return None


def _holds_images(folder: Path) -> bool:
    """True if a folder has images itself: EuRoC's are in a folder below."""
    return any(file.suffix.lower() in ENDINGS for file in folder.iterdir())


def open_folder(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`.

    Raises
    ------
    InputError
        If it lacks images of a side, or a calibration.
    """
    listed = list_pairs(*(_sides(path) or (path / "left", path / "right")))
    poses = list_frame_poses(
        [entry.name for entry in listed],
        find_times(path),
        given_poses(path, settings),
        needs_pose=settings.poses == "given",
    )
    return file_recording(listed, poses, read_calibration(path), settings)


def find_times(path: Path) -> NDArray[np.float64] | None:
    """Times of the frames in seconds, from times.txt or timestamps.txt; None without either."""
    for name in TIMES:
        if (path / name).is_file():
            return read_times(path / name)
    return None


def given_poses(
    path: Path, settings: SequenceSettings, names: Sequence[str] = POSES
) -> GivenPoses | None:
    """The poses of a folder, if any: to be used, or to evaluate estimated ones.

    Raises
    ------
    InputError
        If they are to be used but cannot be read.
    """
    files = [path / name for name in names if (path / name).is_file()]
    if settings.poses == "none" or not files:
        return None
    try:
        return read_poses(files[0])
    except InputError as error:
        if settings.poses == "given":
            raise
        log.warning("%s; poses are estimated without", error)
        return None


def file_recording(
    listed: Sequence[Listed],
    poses: Sequence[FramePose],
    calibration: Calibration,
    settings: SequenceSettings,
) -> Recording:
    """Images in files, each with its time and pose."""
    rectify = rectifier(calibration, first_size(listed))
    eight_bits = first_stretch(listed)
    skipped = [Skipped(name, "it is in neither folder") for name in gaps(listed)]
    frames = []
    for entry, at in islice(zip(listed, poses, strict=True), 0, None, settings.every):
        fault = _fault(entry) or at.fault
        if fault:
            skipped.append(Skipped(entry.name, fault))
            continue
        load = partial(load_pair, entry, at, rectify, eight_bits)
        frames.append(Frame(name=entry.name, stamp_s=at.stamp_s, load=load))
    return Recording(frames, skipped=skipped, disparity_range=calibration.disparity_range)


def first_stretch(listed: Sequence[Listed]) -> Stretch:
    """The stretch from 16 to 8 bits, from both cameras in a few of the first frames."""
    samples: list[Pixels] = []
    for entry in listed[: NUM_FIRST : max(1, NUM_FIRST // 2)]:
        for path in (entry.left, entry.right):
            try:
                samples += [read_pixels(path)] if path else []
            except InputError:  # skipped and counted when its turn comes
                continue
        if samples and samples[0].dtype == np.uint8:
            break
    return stretch_of(samples)


def first_size(listed: Sequence[Listed]) -> tuple[int, int]:
    """(width, height) of the first image that can be read.

    Raises
    ------
    InputError
        If there is none.
    """
    faults = []
    for path in (path for entry in listed for path in (entry.left, entry.right) if path):
        try:
            height, width = read_pixels(path).shape[:2]
        except InputError as error:
            faults.append(str(error))
        else:
            return width, height
    raise InputError(f"no image can be read; the first error: {faults[0]}")


def _fault(entry: Listed) -> str | None:
    if entry.left is None or entry.right is None:
        return f"it has no {'left' if entry.left is None else 'right'} image"
    return None


def load_pair(entry: Listed, at: FramePose, rectify: Rectifier, eight_bits: Stretch) -> StereoPair:
    """The rectified pair of two files."""
    assert entry.left is not None
    assert entry.right is not None
    left, right = read_image(entry.left, eight_bits), read_image(entry.right, eight_bits)
    return rectify.pair(left, right, at.T_world_left, at.stamp_s, entry.name)


READER = Reader(fits=is_folder, open=open_folder)
