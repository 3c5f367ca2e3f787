"""A plain folder: left/, right/, a calibration, and where known poses.txt and times.txt."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.calibration import Calibration, read_calibration
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.images import read_image
from recon.sequences.listing import Listed, list_pairs
from recon.sequences.moments import Moment, list_moments
from recon.sequences.rectification import Rectifier, rectifier
from recon.settings import SequenceSettings


def is_folder(path: Path) -> bool:
    """Whether `path` holds left/ and right/."""
    return (path / "left").is_dir() and (path / "right").is_dir()


def open_folder(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`."""
    listed = list_pairs(path / "left", path / "right")
    return file_recording(path, listed, read_calibration(find_calibration(path)), settings)


def find_calibration(path: Path) -> Path:
    """The one calibration file of a folder.

    Raises
    ------
    InputError
        Where there is none.
    """
    found = [path / "calib.txt", *sorted(path.glob("*.y*ml"))]
    for file in found:
        if file.is_file():
            return file
    raise InputError(f"{path} holds no calibration: calib.txt or a YAML file is needed")


def file_recording(
    path: Path, listed: Sequence[Listed], calibration: Calibration, settings: SequenceSettings
) -> Recording:
    """Pictures in files, each with its row of poses.txt and times.txt where `path` holds them."""
    rectify = rectifier(calibration, first_size(listed))
    moments = list_moments(path, [entry.name for entry in listed], settings.poses)
    frames, skipped = [], []
    for entry, moment in [*zip(listed, moments, strict=True)][:: settings.every]:
        fault = _fault(entry, moment)
        if fault:
            skipped.append(Skipped(entry.name, fault))
            continue
        load = partial(_load, entry, moment, rectify)
        frames.append(Frame(name=entry.name, stamp_s=moment.stamp_s, load=load))
    return Recording(frames, skipped=skipped, disparity_range=calibration.disparity_range)


def first_size(listed: Sequence[Listed]) -> tuple[int, int]:
    """(width, height) of the first picture that can be read."""
    faults = []
    for entry in listed:
        for path in filter(None, (entry.left, entry.right)):
            try:
                height, width = read_image(path).shape[:2]
            except InputError as error:
                faults.append(str(error))
            else:
                return width, height
    raise InputError(f"no picture can be read; the first fault: {faults[0]}")


def _fault(entry: Listed, moment: Moment) -> str | None:
    if entry.left is None or entry.right is None:
        return f"it has no {'left' if entry.left is None else 'right'} picture"
    return moment.fault


def _load(entry: Listed, moment: Moment, rectify: Rectifier) -> StereoPair:
    assert entry.left is not None
    assert entry.right is not None
    left, right = read_image(entry.left), read_image(entry.right)
    return rectify.pair(left, right, moment.T_world_left, moment.stamp_s, entry.name)
