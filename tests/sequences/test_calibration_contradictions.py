"""Calibrations that the images contradict are reported; limits of a single pair are proved."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from recon.camera import StereoRig
from recon.geometry import invert, pose, transform
from recon.notices import collected_notices
from recon.records import StereoPair
from recon.sequences.calibration.files import read_calibration
from recon.sequences.contradictions.angles import angle_finding
from recon.sequences.contradictions.motions import pose_finding
from recon.sequences.contradictions.pairs import findings
from recon.sequences.contradictions.steps import Step
from recon.sequences.images import read_image
from tests.sequences import recordings
from tests.sequences.drives import RIG, motion, tracks
from tests.sequences.recordings import middlebury_keys

KITTI = StereoRig(
    width=1226, height=370, focal_px=707.09, cx_left_px=601.89, cx_right_px=601.89, cy_px=183.11,
    baseline=0.537,
)  # fmt: skip

FOCAL = str(recordings.RIG.focal_px)


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def steps_of(rng, *, field=None, rig=RIG, scale=1.0):
    """Make three steps of a drive, with positions scaled by `scale`."""
    return [_step(tracks(rng, T, field=field), T, rig, scale) for T in [motion(rng) for _ in "abc"]]


def _step(seen, T_first_second, rig, scale):
    image = np.zeros((rig.height, rig.width), np.uint8)
    first = StereoPair(left=image, right=image, rig=rig, name="a", T_world_left=np.eye(4))
    given = pose(T_first_second[:3, :3], scale * T_first_second[:3, 3])
    # The motion that the images show with the focal length of `rig`, to first order.
    ratio = np.diag([1.0, 1.0, rig.focal_px / RIG.focal_px])
    shown = pose(T_first_second[:3, :3], ratio @ T_first_second[:3, 3])
    return Step(
        first=first,
        second=replace(first, name="b", T_world_left=given),
        tracks=seen,
        all_tracks=seen,
        T_second_first=invert(shown),
    )


@pytest.mark.parametrize("offset", [-8.0, -3.0, 3.0, 8.0])
def test_disparity_offset_is_reported_as_an_angle(rng, offset):
    found = angle_finding(steps_of(rng, field=np.array([offset, 0, 0, 0, 0, 0])))
    assert found.code == "angle-differs"
    measured = re.search(r"with disparities (\S+) px", found.text)[1]
    assert float(measured) == pytest.approx(offset, abs=0.5)


@pytest.mark.parametrize("offset", [-1.0, 0.0, 1.0])
def test_usual_rectification_residual_is_not_reported(rng, offset):
    assert angle_finding(steps_of(rng, field=np.array([offset, 0, 0, 0, 0, 0]))) is None
    assert angle_finding([]) is None


@pytest.mark.parametrize("scale", [0.75, 1.3, 10.0])
def test_poses_of_another_scale_are_reported(rng, scale):
    found = pose_finding(steps_of(rng, scale=scale))
    assert found.code == "poses-disagree"
    measured = re.search(r"with positions times (\S+):", found.text)[1]
    assert float(measured) == pytest.approx(1 / scale, rel=0.02)
    assert pose_finding(steps_of(rng, scale=1.05)) is None


def test_scale_of_a_pure_rotation_is_not_judged(rng):
    turn = pose(cv2.Rodrigues(np.array([0.0, 0.05, 0.0]))[0], np.array([0.0, 0.0, 1e-3]))
    assert pose_finding([_step(tracks(rng, turn), turn, RIG, scale=3.0)]) is None


def test_wrong_focal_length_is_reported_by_the_scale_of_the_path(rng):
    found = pose_finding(steps_of(rng, rig=replace(RIG, focal_px=1.5 * RIG.focal_px)))
    assert found.code == "poses-disagree"
    assert "positions times 1.5" in found.text
    assert "focal length" in found.text


def measured_by(rig, points):
    """Project points in the left frame into both images of a rig."""
    left, right = rig.project_left(points), rig.project_right(points)
    return np.column_stack([left, right])


def test_focal_length_is_unobservable_in_one_pair_or_on_a_straight_path(rng):
    """A rig with another focal length measures the same in a world stretched in depth."""
    other = replace(RIG, focal_px=1.5 * RIG.focal_px)
    points = RIG.rays(rng.uniform(0, 370, (500, 2))) * rng.uniform(5, 40, (500, 1))
    step = np.array([0.1, 0.05, 1.2])
    for moved, by in ((points, np.zeros(3)), (points - step, step)):
        measured = measured_by(RIG, moved)
        deeper = points * (1.0, 1.0, 1.5) - by * (1.0, 1.0, 1.5)
        np.testing.assert_allclose(measured_by(other, deeper), measured, atol=1e-9)
    # A rotation reveals it: no rigid motion of the stretched world gives these images.
    turned = transform(pose(cv2.Rodrigues(np.array([0.0, 0.1, 0.0]))[0], step), points)
    assert (
        np.abs(measured_by(other, turned * (1.0, 1.0, 1.5)) - measured_by(RIG, turned)).max() < 1e-9
    )
    back = other.triangulate(measured_by(RIG, turned)[:, :2], _disparity(measured_by(RIG, turned)))
    rigid = np.linalg.lstsq(
        np.column_stack([points * (1.0, 1.0, 1.5), np.ones(len(points))]), back, rcond=None
    )[0][:3]
    assert np.abs(rigid.T @ rigid - np.eye(3)).max() > 0.05


def _disparity(measured):
    return measured[:, 0] - measured[:, 2]


def warped(image, homography):
    return cv2.warpPerspective(image, homography, image.shape[1::-1], borderMode=cv2.BORDER_REFLECT)


def turned(image, degrees):
    K = np.array(
        [[KITTI.focal_px, 0, KITTI.cx_left_px], [0, KITTI.focal_px, KITTI.cy_px], [0, 0, 1]]
    )
    return warped(image, K @ cv2.Rodrigues(np.radians([0.0, degrees, 0.0]))[0] @ np.linalg.inv(K))


def distorted(image, k):
    """Distort an image radially; `k` is the relative displacement at the corners."""
    height, width = image.shape
    centre, radius = np.array([width - 1, height - 1]) / 2, np.hypot(width - 1, height - 1) / 2
    grid = (np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1) - centre) / radius
    places = (grid * (1 + k * (grid**2).sum(-1, keepdims=True)) * radius + centre).astype(
        np.float32
    )
    return cv2.remap(image, places, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)


@pytest.fixture(scope="module")
def drive(data_dir):
    folder = data_dir / "kitti_odometry" / "sequence_1"
    return [read_image(folder / side / "000045.png") for side in ("left", "right")]


def codes(left, right):
    return [finding.code for finding in findings(left, right, rig=KITTI)]


@pytest.mark.data
@pytest.mark.parametrize("degrees", [-2.0, 1.0, 2.0])
def test_camera_rotated_about_the_vertical_is_reported(drive, degrees):
    left, right = drive
    assert codes(left, turned(right, degrees)) == ["angle-differs"]


@pytest.mark.data
def test_remaining_distortion_is_reported(drive):
    left, right = drive
    assert codes(left, right) == []
    for k in (-0.15, 0.1):
        assert codes(distorted(left, k), distorted(right, k)) == ["rows-differ"]
    assert codes(left, distorted(right, -0.1)) == ["rows-differ"]


def notices_of(path):
    with collected_notices() as notices:
        read_calibration(path)
    return [one for one in notices if one.code == "calibration-contradictory"]


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("calib.yaml", lambda text: text, None),
        ("calib_old.txt", lambda text: text.replace("baseline=", "baseline=1"), "baselines"),
        ("calib_old.txt", lambda text: text.replace(FOCAL, "150.0"), "focal lengths"),
        ("notes.txt", lambda text: text.replace("baseline=", "baseline=1"), None),
    ],
)
def test_calibrations_of_a_folder_that_differ_are_reported(tmp_path, name, change, said):
    text = middlebury_keys()
    (tmp_path / "calib.txt").write_text(text)
    (tmp_path / name).write_text(change(text))
    notices = notices_of(tmp_path)
    assert len(notices) == (said is not None)
    if said:
        assert f"state different {said} (" in notices[0].text
        assert notices[0].text.endswith("calib.txt is used")


@pytest.mark.parametrize(("doffs", "is_said"), [("0", False), ("0.6", False), ("31.1", True)])
def test_offset_that_differs_from_the_principal_points_is_reported(tmp_path, doffs, is_said):
    text = middlebury_keys().replace("doffs=0", f"doffs={doffs}")
    (tmp_path / "calib.txt").write_text(text)
    assert len(notices_of(tmp_path / "calib.txt")) == is_said


@pytest.mark.parametrize(("baseline", "is_said"), [("0.193", True), ("193.001", False)])
def test_baseline_of_middlebury_in_metres_is_reported(tmp_path, baseline, is_said):
    text = re.sub(r"baseline=.*", f"baseline={baseline}", middlebury_keys())
    (tmp_path / "calib.txt").write_text(text)
    notices = notices_of(tmp_path / "calib.txt")
    assert ["write 193" in one.text for one in notices] == [True] * is_said
