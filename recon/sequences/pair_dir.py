"""A single pair: left.*, right.*, where known a calibration and the truth (Middlebury)."""

from pathlib import Path

from recon.errors import InputError
from recon.sequences.calibration import read_calibration
from recon.sequences.folder import file_recording, find_calibration
from recon.sequences.frames import Recording
from recon.sequences.images import ENDINGS
from recon.sequences.listing import Listed
from recon.settings import SequenceSettings

MIDDLEBURY_NAMES = {
    "left": ("left", "im0", "view1", "im2"),
    "right": ("right", "im1", "view5", "im6"),
}
"""What a side is called: here, and in Middlebury's sets of 2014, 2005/6 and 2001/3."""


def is_pair_dir(path: Path) -> bool:
    """Whether `path` holds one left and one right picture."""
    try:
        return bool(find_picture(path, "left") and find_picture(path, "right"))
    except InputError:
        return False


def open_pair_dir(path: Path, settings: SequenceSettings) -> Recording:
    """The one pair in `path`; the world's origin is its left eye."""
    pair = Listed(
        name=path.name, left=find_picture(path, "left"), right=find_picture(path, "right")
    )
    return file_recording(path, [pair], read_calibration(find_calibration(path)), settings)


def find_picture(path: Path, side: str) -> Path:
    """The picture of `side` ("left" or "right") of a pair folder.

    Raises
    ------
    InputError
        Where there is none.
    """
    for stem in MIDDLEBURY_NAMES[side]:
        for file in sorted(path.glob(f"{stem}.*")):
            if file.suffix.lower() in ENDINGS:
                return file
    raise InputError(f"{path} holds no {side} picture ({side}.png or the like)")
