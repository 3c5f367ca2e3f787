"""Recordings and boards on the command line."""

import json

import numpy as np
import pytest

from recon.cli import main

pytestmark = pytest.mark.usefixtures("without_figures")


@pytest.mark.data
def test_drive_without_poses_is_reconstructed(data_dir, tmp_path, capsys):
    run = tmp_path / "drive"
    argv = ["reconstruct", str(data_dir / "kitti_odometry" / "sequence_1"), "-o", str(run)]
    argv += ["--poses", "estimated", "--every", "3", "--quality", "fast"]
    assert main([*argv, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["num_pairs"] == 17
    assert 0 < report["drift_percent"] < 2
    assert 0.4 < report["confirmed_share"] < 1
    trajectory = np.loadtxt(run / "trajectory.txt")
    assert trajectory.shape == (17, 8)
    length = np.linalg.norm(np.diff(trajectory[:, 1:4], axis=0), axis=1).sum()
    assert 50 < length < 65


@pytest.mark.data
def test_boards_give_a_calibration(data_dir, tmp_path, capsys):
    boards = str(data_dir / "chessboard_stereo" / "opencv")
    out = tmp_path / "calib.yaml"
    argv = ["calibrate", boards, boards, "--board", "9x6", "--square", "1", "-o", str(out)]
    assert main([*argv, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["num_pairs"] == 13
    assert 0.1 < report["rms_px"] < 0.25
    assert 3.2 < report["baseline"] < 3.5
    assert main(argv) == 2
    assert main([*argv[:3], "--board", "nine", "--square", "1", "-o", str(out)]) == 2
