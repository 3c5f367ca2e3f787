"""Regression tests on recorded data."""

import json

import cv2
import numpy as np
import pytest
import yaml

from recon.sequences import open_sequence, read_truth
from recon.sequences.estimated_poses import EstimatedPoses
from recon.settings import SequenceSettings

pytestmark = pytest.mark.data


def test_odometry_keeps_the_scale_of_a_drive(data_dir):
    """Every second of 51 pairs over 60 m; bounds are 0.5 % and, for the end point, 2 %."""
    path = data_dir / "kitti_odometry" / "sequence_1"
    estimating = SequenceSettings(poses="estimated", every=2)
    source = open_sequence(path, estimating, checks=False)
    assert isinstance(source, EstimatedPoses)
    estimated = [pair.T_world_left for pair in source]
    given = open_sequence(path, SequenceSettings(every=2), checks=False)
    true = [pair.T_world_left for pair in given]
    assert 0 < source.metrics["drift_percent"] < 0.5
    assert source.carried == []
    end = np.linalg.norm((estimated[-1] - true[-1])[:3, 3])
    assert end < 0.02 * 59.9
    assert source.residual.row.coefficients[4] == pytest.approx(1.5, abs=0.3)


def test_euroc_rows_correspond_after_rectification(data_dir, tmp_path):
    recorded = data_dir / "euroc" / "v1_four_frames"
    for name in ("left", "right", "poses.txt"):
        (tmp_path / name).symlink_to(recorded / name)
    rig = json.loads((recorded / "meta.json").read_text())["calibration"]
    cameras = {name: _kalibr(rig[name]) for name in ("cam0", "cam1")}
    cameras["cam1"]["T_cn_cnm1"] = rig["T_cam1_cam0"]
    (tmp_path / "camchain.yaml").write_text(yaml.safe_dump(cameras))
    offsets = [_row_offsets(pair) for pair in open_sequence(tmp_path, SequenceSettings())]
    assert len(offsets) == 4
    median = np.median(np.abs(np.concatenate(offsets)))
    assert 0.05 < median < 0.15


def _kalibr(camera):
    K = camera["K"]
    return {
        "camera_model": "pinhole",
        "distortion_model": "radtan",
        "distortion_coeffs": camera["dist"],
        "intrinsics": [K[0][0], K[1][1], K[0][2], K[1][2]],
        "resolution": [752, 480],
    }


def _row_offsets(pair):
    """Compute v_right - v_left of matched scale-invariant features."""
    sift = cv2.SIFT_create()
    (points, left), (others, right) = (
        sift.detectAndCompute(i, None) for i in (pair.left, pair.right)
    )
    both = cv2.BFMatcher().knnMatch(left, right, k=2)
    good = [first for first, second in both if first.distance < 0.75 * second.distance]
    offset = np.array([others[m.trainIdx].pt[1] - points[m.queryIdx].pt[1] for m in good])
    return offset[np.abs(offset) < 5]


@pytest.mark.parametrize(
    ("pair", "step"), [("middlebury2001/tsukuba", 1.0), ("middlebury2003/cones", 1 / 4)]
)
def test_truth_has_the_documented_sign_and_scale(data_dir, pair, step):
    """A left pixel corresponds to x - disparity in the right image, not to x + disparity."""
    path = data_dir / pair
    truth = read_truth(path)
    assert truth.quantisation_px == step
    left, right = (
        cv2.imread(str(path / f"{side}.png"), 0).astype(np.float32) for side in ("left", "right")
    )
    v, u = np.mgrid[: left.shape[0], : left.shape[1]].astype(np.float32)

    def difference(sign):
        shifted = (u - sign * np.nan_to_num(truth.disparity_px, nan=1e6)).astype(np.float32)
        there = cv2.remap(right, shifted, v, cv2.INTER_LINEAR, borderValue=float("nan"))
        return np.nanmedian(np.abs(there - left))

    assert difference(+1) < 5
    assert difference(-1) > 2 * difference(+1)
