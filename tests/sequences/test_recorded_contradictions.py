"""Contradictions in a recorded drive are reported with a code; the unchanged drive gives none."""

import cv2
import numpy as np
import pytest

from recon.notices import collected_notices
from recon.sequences import open_sequence
from recon.sequences.pose_files import read_poses
from recon.settings import SequenceSettings

NUM_PAIRS = 3
T_BODY_CAMERA = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""x forward, y left, z up."""


def drive(data_dir, path, *, first=20, sides=("left", "right"), late=0, rows=0, poses=None):
    """Write some pairs of the recorded drive with a fault."""
    recorded = data_dir / "kitti_odometry" / "sequence_1"
    for side, source, shift in zip(("left", "right"), sides, (0, late), strict=True):
        (path / side).mkdir(parents=True)
        for number in range(NUM_PAIRS):
            image = cv2.imread(str(recorded / source / f"{first + number + shift:06d}.png"), -1)
            moved = np.roll(image, rows if side == "right" else 0, axis=0)
            cv2.imwrite(str(path / side / f"{number:06d}.png"), moved)
    (path / "calib.txt").write_text((recorded / "calib.txt").read_text())
    given = read_poses(recorded / "poses.txt").poses[first : first + NUM_PAIRS]
    changed = given if poses is None else poses(given)
    rows_of_text = (" ".join(f"{v:.9e}" for v in T[:3].ravel()) for T in changed)
    (path / "poses.txt").write_text("\n".join(rows_of_text))
    return path


def notices_of(path, **settings):
    with collected_notices() as notices:
        assert len(list(open_sequence(path, SequenceSettings(**settings)))) == NUM_PAIRS
    return {notice.code: notice.text for notice in notices}


@pytest.mark.data
def test_correct_drive_gives_no_notices(data_dir, tmp_path):
    assert notices_of(drive(data_dir, tmp_path / "later")) == {}


@pytest.mark.data
def test_corrupted_pairs_of_a_drive_are_reported(data_dir, tmp_path):
    swapped = drive(data_dir, tmp_path / "swapped", sides=("right", "left"))
    assert [*notices_of(swapped)] == ["left-right-swapped"]
    assert [*notices_of(drive(data_dir, tmp_path / "rows", rows=2))] == ["rows-differ"]
    assert [*notices_of(drive(data_dir, tmp_path / "late", late=1))] == ["not-simultaneous"]
    assert [*notices_of(drive(data_dir, tmp_path / "early", late=-1))] == ["not-simultaneous"]


@pytest.mark.data
@pytest.mark.parametrize(
    ("change", "word"),
    [
        (np.linalg.inv, "inverted"),
        (lambda T: T @ np.linalg.inv(T_BODY_CAMERA), "axes are not the camera's"),
        (lambda T: T[::-1], "opposite order"),
        (lambda T: _scaled(T, 1000.0), "with positions times 0.001"),  # in millimetres
        (lambda T: _scaled(T, 1.3), "with positions times 0.77"),
    ],
)
def test_wrong_pose_conventions_are_reported(data_dir, tmp_path, change, word):
    path = drive(data_dir, tmp_path / "drive", poses=change)
    found = notices_of(path)
    assert [*found] == ["poses-disagree"]
    assert word in found["poses-disagree"]
    if change is np.linalg.inv:
        assert notices_of(path, poses="estimated") == {}


def _scaled(poses, factor):
    far = poses.copy()
    far[:, :3, 3] *= factor
    return far


@pytest.mark.data
def test_poses_wrong_from_the_middle_on_are_reported(data_dir, tmp_path, monkeypatch):
    monkeypatch.setattr("tests.sequences.test_recorded_contradictions.NUM_PAIRS", 16)

    def with_reversed_end(poses):
        return np.concatenate([poses[:12], poses[12:][::-1]])

    found = notices_of(drive(data_dir, tmp_path / "drive", first=0, poses=with_reversed_end))
    assert [*found] == ["poses-disagree"]
    assert "near 0000" in found["poses-disagree"]
