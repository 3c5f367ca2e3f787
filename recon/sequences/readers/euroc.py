"""EuRoC (ASL) format: cam0, cam1 with data.csv and sensor.yaml, ground truth of the body."""

from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.sequences.calibration.chains import read_sensors
from recon.sequences.frames import Recording
from recon.sequences.images import ENDINGS
from recon.sequences.listing import Listed
from recon.sequences.readers.folder import file_recording, given_poses
from recon.sequences.readers.reader import Reader
from recon.sequences.text import read_lines
from recon.sequences.timestamps import list_frame_poses
from recon.settings import SequenceSettings

NANOSECONDS = 1e-9


def is_euroc(path: Path) -> bool:
    """True if `path`, or its mav0, contains cam0 and cam1 with their sensor.yaml."""
    return all((_root(path) / camera / "sensor.yaml").is_file() for camera in ("cam0", "cam1"))


def open_euroc(path: Path, settings: SequenceSettings) -> Recording:
    """The recording in `path`: images with the same timestamp form a pair."""
    root = _root(path)
    calibration, T_body_left = read_sensors(
        root / "cam0" / "sensor.yaml", root / "cam1" / "sensor.yaml"
    )
    lefts, rights = (_stamped(root / camera) for camera in ("cam0", "cam1"))
    stamps = sorted(lefts.keys() | rights.keys())
    listed = [Listed(name=str(t), left=lefts.get(t), right=rights.get(t)) for t in stamps]
    truth = given_poses(root / "state_groundtruth_estimate0", settings, ("data.csv",))
    poses = list_frame_poses(
        [entry.name for entry in listed],
        NANOSECONDS * np.array(stamps),
        truth and truth.of(T_body_left),
        needs_pose=settings.poses == "given",
    )
    return file_recording(listed, poses, calibration, settings)


def _root(path: Path) -> Path:
    return path / "mav0" if (path / "mav0").is_dir() else path


def _stamped(camera: Path) -> dict[int, Path]:
    """Images of a camera by their time in nanoseconds, from data.csv or their names."""
    table = camera / "data.csv"
    if not table.is_file():
        files = [f for f in (camera / "data").glob("*.*") if f.suffix.lower() in ENDINGS]
        return {int(file.stem): file for file in files if file.stem.isdigit()}
    found = {}
    for number, line in enumerate(read_lines(table), start=1):
        stamp, _, name = line.partition("#")[0].partition(",")
        if not stamp.strip():
            continue
        if not stamp.strip().isdigit() or not name.strip():
            raise InputError(f"{table}, line {number}: {line[:60]!r} is not a time and file name")
        found[int(stamp)] = camera / "data" / name.strip()
    return found


READER = Reader(fits=is_euroc, open=open_euroc)
