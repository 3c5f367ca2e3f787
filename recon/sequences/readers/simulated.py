"""Views of the simulated world: a folder of exported frames, each with its own rig.

Cameras that fixate their target have different principal points in every view, so that no single
calibration fits them all.
"""

from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

from recon.errors import InputError
from recon.records import StereoPair
from recon.sequences.frames import Frame, Recording, Skipped
from recon.sequences.listing import natural
from recon.sequences.readers.folder import find_times, given_poses
from recon.sequences.readers.pair_dir import is_pair_dir, open_pair_dir
from recon.sequences.readers.reader import Reader
from recon.sequences.timestamps import FramePose, list_frame_poses
from recon.settings import SequenceSettings


def is_simulated(path: Path) -> bool:
    """True if `path` contains folders of pairs."""
    return bool(_pair_dirs(path))


def open_simulated(path: Path, settings: SequenceSettings) -> Recording:
    """The pairs in the folders of `path`, each with a row of poses.txt and times.txt."""
    folders = _pair_dirs(path)
    if not folders:
        raise InputError(f"{path} contains no folders with left.* and right.*")
    poses = list_frame_poses(
        [folder.name for folder in folders],
        find_times(path),
        given_poses(path, settings),
        needs_pose=settings.poses == "given",
    )
    frames, skipped = [], []
    for folder, at in islice(zip(folders, poses, strict=True), 0, None, settings.every):
        if at.fault:
            skipped.append(Skipped(folder.name, at.fault))
            continue
        load = partial(_load, folder, at, settings)
        frames.append(Frame(name=folder.name, stamp_s=at.stamp_s, load=load))
    return Recording(frames, skipped=skipped)


def _load(folder: Path, at: FramePose, settings: SequenceSettings) -> StereoPair:
    pair = next(iter(open_pair_dir(folder, settings)))
    return replace(pair, T_world_left=at.T_world_left, stamp_s=at.stamp_s)


def _pair_dirs(path: Path) -> list[Path]:
    if not path.is_dir():
        return []
    folders = [folder for folder in path.iterdir() if folder.is_dir() and is_pair_dir(folder)]
    return sorted(folders, key=lambda folder: natural(folder.name))


READER = Reader(fits=is_simulated, open=open_simulated)
