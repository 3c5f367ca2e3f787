"""A plain folder: left/, right/, a calibration, and where known poses.txt and times.txt."""

from collections.abc import Sequence
from functools import partial
from itertools import islice
from pathlib import Path

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.calibration.cameras import Calibration
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import Rectifier, rectifier
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.images import read_image
from recon.sequences.listing import Listed, gaps, list_pairs
from recon.sequences.poses import Trajectory, read_trajectory
from recon.sequences.timestamps import Moment, list_moments, read_times
from recon.settings import SequenceSettings


def is_folder(path: Path) -> bool:
    """Whether `path` holds left/ and right/."""
    return (path / "left").is_dir() and (path / "right").is_dir()


def open_folder(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`."""
    listed = list_pairs(path / "left", path / "right")
    moments = list_moments(
        [entry.name for entry in listed],
        read_times(path / "times.txt"),
        given_trajectory(path / "poses.txt", settings),
        needs_pose=settings.poses == "given",
    )
    return file_recording(listed, moments, read_calibration(find_calibration(path)), settings)


def find_calibration(path: Path) -> Path:
    """The calibration file of a folder: calib.txt, or the first YAML file.

    Raises
    ------
    InputError
        Where there is none.
    """
    for file in [path / "calib.txt", *sorted(path.glob("*.yaml")), *sorted(path.glob("*.yml"))]:
        if file.is_file():
            return file
    raise InputError(f"{path} holds no calibration: calib.txt or a YAML file is needed")


def given_trajectory(path: Path, settings: SequenceSettings) -> Trajectory | None:
    """The poses of a file where there is one: to be used, or to judge estimated ones by."""
    return read_trajectory(path) if settings.poses != "none" and path.is_file() else None


def file_recording(
    listed: Sequence[Listed],
    moments: Sequence[Moment],
    calibration: Calibration,
    settings: SequenceSettings,
) -> Recording:
    """Images in files, each with its moment."""
    rectify = rectifier(calibration, first_size(listed))
    skipped = [Skipped(name, "it is in neither folder") for name in gaps(listed)]
    frames = []
    for entry, moment in islice(zip(listed, moments, strict=True), 0, None, settings.every):
        fault = _fault(entry) or moment.fault
        if fault:
            skipped.append(Skipped(entry.name, fault))
            continue
        load = partial(_load, entry, moment, rectify)
        frames.append(Frame(name=entry.name, stamp_s=moment.stamp_s, load=load))
    return Recording(frames, skipped=skipped, disparity_range=calibration.disparity_range)


def first_size(listed: Sequence[Listed]) -> tuple[int, int]:
    """(width, height) of the first image that can be read.

    Raises
    ------
    InputError
        Where none can.
    """
    faults = []
    for path in (path for entry in listed for path in (entry.left, entry.right) if path):
        try:
            height, width = read_image(path).shape[:2]
        except InputError as error:
            faults.append(str(error))
        else:
            return width, height
    raise InputError(f"no image can be read; the first fault: {faults[0]}")


def _fault(entry: Listed) -> str | None:
    if entry.left is None or entry.right is None:
        return f"it has no {'left' if entry.left is None else 'right'} image"
    return None


def _load(entry: Listed, moment: Moment, rectify: Rectifier) -> StereoPair:
    assert entry.left is not None
    assert entry.right is not None
    left, right = read_image(entry.left), read_image(entry.right)
    return rectify.pair(left, right, moment.T_world_left, moment.stamp_s, entry.name)
