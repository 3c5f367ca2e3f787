"""KITTI's layouts: odometry, raw drives, and the stereo sets of 2012 and 2015.

Grey images are in image_0 and image_1 (raw: image_00, image_01), colour in image_2 and image_3
(raw: image_02, image_03; 2012: colored_0, colored_1); some copies name them image_l and image_r.
"""

from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.calibration.files import read_calibration
from recon.sequences.calibration.rectification import rectifier
from recon.sequences.calibration.rows import Cameras, T_camera0_left
from recon.sequences.depth import Stretch
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.images import read_pixels
from recon.sequences.listing import Listed, list_pairs
from recon.sequences.poses import GivenPoses
from recon.sequences.readers.folder import (
    file_recording,
    find_times,
    first_stretch,
    given_poses,
    load_pair,
)
from recon.sequences.readers.reader import Reader
from recon.sequences.timestamps import FramePose, list_frame_poses, read_times
from recon.settings import SequenceSettings

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sides:
    """Two image folders and the numbers of their cameras."""

    left: str
    right: str
    cameras: Cameras | None


SIDES = (  # colour before grey
    _Sides(left="image_2", right="image_3", cameras=(2, 3)),
    _Sides(left="image_02", right="image_03", cameras=(2, 3)),
    _Sides(left="colored_0", right="colored_1", cameras=(2, 3)),
    _Sides(left="image_0", right="image_1", cameras=(0, 1)),
    _Sides(left="image_00", right="image_01", cameras=(0, 1)),
    _Sides(left="image_l", right="image_r", cameras=None),
)
CALIBRATIONS = ("calib.txt", "calib_cam_to_cam.txt")
MANY_CALIBRATIONS = ("calib_cam_to_cam", "calib")
"""Folders with a file per scene, in the 2015 and 2012 sets."""


def is_kitti(path: Path) -> bool:
    """True if `path` contains the image folders of a KITTI recording."""
    return _sides(path) is not None


def open_kitti(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`; its poses are camera 0's, converted to the left camera used."""
    sides = _sides(path)
    if sides is None:
        names = ", ".join(f"{one.left} and {one.right}" for one in SIDES)
        raise InputError(f"{path} contains neither of {names}")
    listed = list_pairs(_images(path / sides.left), _images(path / sides.right))
    calib = _calibration(path)
    if calib is None:
        return _scenes(path, sides, listed, settings)
    given = given_poses(path, settings) or _archived_poses(path, settings)
    if given is not None and sides.cameras is not None:
        given = given.of(T_camera0_left(calib, sides.cameras))
    poses = list_frame_poses(
        [entry.name for entry in listed],
        _times(path, sides),
        given,
        needs_pose=settings.poses == "given" and given is not None,
    )
    return file_recording(listed, poses, read_calibration(calib, sides.cameras), settings)


def _sides(path: Path) -> _Sides | None:
    found = (one for one in SIDES if (path / one.left).is_dir() and (path / one.right).is_dir())
    return next(found, None)


def _images(folder: Path) -> Path:
    """The folder of the images, which is data/ in KITTI raw."""
    return folder / "data" if (folder / "data").is_dir() else folder


def _calibration(path: Path) -> Path | None:
    """The calibration of a recording, in its folder or, for raw drives, one or two levels up."""
    for folder in (path, path.resolve().parent, path.resolve().parent.parent):
        for name in CALIBRATIONS:
            # A level up only KITTI raw's own name is accepted: calib.txt may belong to anything.
            if (folder / name).is_file() and (folder == path or name == CALIBRATIONS[1]):
                return folder / name
    if any((path / name).is_dir() for name in MANY_CALIBRATIONS):
        return None
    raise InputError(f"{path} holds no calibration: {' or '.join(CALIBRATIONS)} is needed")


def _times(path: Path, sides: _Sides) -> Array | None:
    """Times in seconds: times.txt of the recording, or timestamps.txt of the left camera (raw)."""
    times = find_times(path)
    return read_times(path / sides.left / "timestamps.txt") if times is None else times


def _archived_poses(path: Path, settings: SequenceSettings) -> GivenPoses | None:
    """Poses at KITTI odometry's location: ../../poses/NAME.txt."""
    own = path.resolve()
    return given_poses(own.parent.parent / "poses", settings, (f"{own.name}.txt",))


def _scenes(
    path: Path, sides: _Sides, listed: list[Listed], settings: SequenceSettings
) -> Recording:
    """Pairs of the stereo sets: each has its own calibration, and no pose."""
    folder = next(path / name for name in MANY_CALIBRATIONS if (path / name).is_dir())
    eight_bits = first_stretch(listed)
    frames, skipped = [], []
    for number, entry in islice(enumerate(listed), 0, None, settings.every):
        if entry.left is None or entry.right is None:
            side = "left" if entry.left is None else "right"
            skipped.append(Skipped(entry.name, f"it has no {side} image"))
            continue
        calib = folder / f"{entry.name.partition('_')[0]}.txt"
        load = partial(_load_scene, entry, float(number), calib, sides, eight_bits)
        frames.append(Frame(name=entry.name, stamp_s=float(number), load=load))
    return Recording(frames, skipped=skipped)


def _load_scene(
    entry: Listed, stamp_s: float, calib: Path, sides: _Sides, eight_bits: Stretch
) -> StereoPair:
    assert entry.left is not None
    height, width = read_pixels(entry.left).shape[:2]
    rectify = rectifier(read_calibration(calib, sides.cameras), (width, height))
    return load_pair(entry, FramePose(stamp_s=stamp_s), rectify, eight_bits)


READER = Reader(fits=is_kitti, open=open_kitti)
