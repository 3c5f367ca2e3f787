"""A single pair: left.*, right.*, a calibration, optional ground truth (Middlebury)."""

from pathlib import Path

from recon.errors import InputError
from recon.sequences.calibration.files import read_calibration
from recon.sequences.frames import Recording
from recon.sequences.images import ENDINGS
from recon.sequences.listing import Listed
from recon.sequences.readers.folder import file_recording
from recon.sequences.readers.reader import Reader
from recon.sequences.timestamps import FramePose
from recon.settings import SequenceSettings

NAMES = {
    "left": ("left", "im0", "view1", "im2"),
    "right": ("right", "im1", "view5", "im6"),
}
"""Names per side: recon's, and those of Middlebury 2014, 2005 and 2006, 2001 and 2003."""


def is_pair_dir(path: Path) -> bool:
    """True if `path` contains one left and one right image."""
    return path.is_dir() and all(_image(path, side) for side in NAMES)


def open_pair_dir(path: Path, settings: SequenceSettings) -> Recording:
    """The single pair in `path`, without a pose."""
    pair = Listed(
        name=path.resolve().name, left=find_image(path, "left"), right=find_image(path, "right")
    )
    at = FramePose(stamp_s=0.0, T_world_left=None)
    calibration = read_calibration(path)
    return file_recording([pair], [at], calibration, settings)


def find_image(path: Path, side: str) -> Path:
    """The image of `side` ("left" or "right") of a pair folder.

    Raises
    ------
    InputError
        If there is none.
    """
    found = _image(path, side)
    if found is None:
        raise InputError(f"{path} contains no {side} image ({side}.png or the like)")
    return found


def _image(path: Path, side: str) -> Path | None:
    files = (file for stem in NAMES[side] for file in sorted(path.glob(f"{stem}.*")))
    return next((file for file in files if file.suffix.lower() in ENDINGS), None)


READER = Reader(fits=is_pair_dir, open=open_pair_dir)
