"""A reader: a whole recording in one .npz of left, right (N, H, W), focal_px and baseline."""

from functools import partial
from pathlib import Path

import numpy as np

import recon
from recon.sequences.frames import Frame, Recording
from recon.sequences.readers.reader import Reader


def fits(path: Path) -> bool:
    """True if it is such a file."""
    if path.suffix != ".npz" or not path.is_file():
        return False
    with np.load(path, allow_pickle=False) as file:
        return {"left", "right", "focal_px", "baseline"} <= set(file)


def open_npz(path: Path, settings: recon.SequenceSettings) -> Recording:
    """The pairs of the file, every `settings.every`-th."""
    with np.load(path, allow_pickle=False) as file:
        numbers = range(0, len(file["left"]), settings.every)
    frames = [Frame(name=str(n), stamp_s=float(n), load=partial(_load, path, n)) for n in numbers]
    return Recording(frames)


def _load(path: Path, number: int) -> recon.StereoPair:
    with np.load(path, allow_pickle=False) as file:
        left, right = file["left"][number], file["right"][number]
        focal_px, baseline = float(file["focal_px"]), float(file["baseline"])
    height, width = left.shape[:2]
    middle = (width - 1) / 2.0
    rig = recon.StereoRig(
        width=width, height=height, focal_px=focal_px, baseline=baseline,
        cx_left_px=middle, cx_right_px=middle, cy_px=(height - 1) / 2.0,
    )  # fmt: skip
    return recon.StereoPair(
        left=left, right=right, rig=rig, T_world_left=np.diag([1.0, -1.0, -1.0, 1.0]),
        stamp_s=float(number), name=f"{path.name}, pair {number}",
    )  # fmt: skip


READER = Reader(fits=fits, open=open_npz)
