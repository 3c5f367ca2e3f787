"""Rows correspond after rectification, and the rectified rig measures world points."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose, transform
from recon.notices import collected_notices
from recon.sequences.calibration.cameras import Calibration, Camera
from recon.sequences.calibration.rectification import common_axes, rectifier

SIZE = (320, 240)
K = np.array([[260.0, 0, 163.0], [0, 258.0, 118.0], [0, 0, 1]])
BARREL = np.array([-0.28, 0.07, 2e-4, 1e-5])
FISHEYE = np.array([-0.02, 0.01, -0.003, 0.001])


def calibration(turn, step, *, distortion=BARREL, is_fisheye=False):
    camera = Camera(matrix=K, distortion=distortion, is_fisheye=is_fisheye)
    R = Rotation.from_rotvec(turn).as_matrix()
    return Calibration(left=camera, right=camera, T_right_left=pose(R, step))


def raw_position_of(maps, points_px):
    """Look up the raw position of a rectified pixel."""
    u, v = np.rint(points_px).astype(int).T
    return np.column_stack([maps[0][v, u], maps[1][v, u]])


def raw_pixels(camera, points_camera):
    zero = np.zeros(3)
    lens = cv2.fisheye if camera.is_fisheye else cv2
    if camera.is_fisheye:
        raw = lens.projectPoints(
            points_camera[:, None], zero, zero, camera.matrix, camera.distortion
        )[0]
    else:
        raw = lens.projectPoints(points_camera, zero, zero, camera.matrix, camera.distortion)[0]
    return raw.reshape(-1, 2)


def check(rig):
    """Check that rectified pixels of world points come from the raw pixels of the same points."""
    size = SIZE
    rectify = rectifier(rig, size)
    rng = np.random.default_rng(3)
    u = rng.integers(40, rectify.rig.width - 40, 50)
    v = rng.integers(40, rectify.rig.height - 40, 50)
    pixels = np.column_stack([u, v]).astype(float)
    disparity = rng.integers(4, 20, 50).astype(float)
    points_rectified = rectify.rig.triangulate(pixels, disparity)
    points_left = transform(rectify.T_raw_rectified, points_rectified)
    points_right = transform(rig.T_right_left, points_left)
    shift = np.column_stack([disparity, np.zeros(50)])
    for camera, points, seen, maps in (
        (rig.left, points_left, pixels, rectify.maps[0]),
        (rig.right, points_right, pixels - shift, rectify.maps[1]),
    ):
        np.testing.assert_allclose(
            raw_position_of(maps, seen), raw_pixels(camera, points), atol=2e-3
        )


@settings(max_examples=15)
@given(
    turn=st.tuples(*[st.floats(-0.05, 0.05)] * 3),
    step=st.tuples(st.floats(-0.3, -0.1), st.floats(-0.02, 0.02), st.floats(-0.02, 0.02)),
)
def test_rectified_pixels_come_from_the_raw_pixels_of_the_same_point(turn, step):
    check(calibration(turn, step))


def test_fisheye_rig_is_rectified():
    check(calibration([0.01, 0.02, -0.01], [-0.2, 0.0, 0.0], distortion=FISHEYE, is_fisheye=True))


@pytest.mark.parametrize("below", [-1.0, 1.0])
def test_vertical_rig_is_rotated_by_a_quarter_turn(below):
    rig = calibration([0.01, -0.02, 0.01], [0.005, 0.2 * below, 0.01])
    rectify = rectifier(rig, SIZE)
    assert (rectify.rig.width, rectify.rig.height) == SIZE[::-1]
    check(rig)


def test_rectified_images_have_no_empty_pixels_and_opencvs_field_of_view():
    rig = calibration([0.01, 0.02, -0.01], [-0.2, 0.003, 0.002])
    rectify = rectifier(rig, SIZE)
    white = np.full(SIZE[::-1], 255, np.uint8)
    assert min(image.min() for image in rectify(white, white)) == 255
    T = rig.T_right_left
    theirs = cv2.stereoRectify(
        K, BARREL, K, BARREL, SIZE, T[:3, :3], T[:3, 3:], alpha=0,
        flags=cv2.CALIB_ZERO_DISPARITY,
    )  # fmt: skip
    assert 0.95 < rectify.rig.focal_px / theirs[2][0, 0] < 1.05


def test_rows_do_not_correspond_before_rectification():
    rig = calibration([0.03, 0.0, 0.0], [-0.2, 0.0, 0.0])
    points_left = np.random.default_rng(0).uniform([-1, -1, 3], [1, 1, 6], (50, 3))
    left = raw_pixels(rig.left, points_left)
    right = raw_pixels(rig.right, transform(rig.T_right_left, points_left))
    assert np.abs(left[:, 1] - right[:, 1]).min() > 5


def test_rectified_images_stay_unchanged():
    rig = calibration([0, 0, 0], [-0.2, 0, 0], distortion=np.zeros(0))
    K_square = np.array([[260.0, 0, 163], [0, 260, 118], [0, 0, 1]])
    square = Camera(matrix=K_square, distortion=np.zeros(5))
    rig = Calibration(left=square, right=square, T_right_left=rig.T_right_left)
    image = np.random.default_rng(0).integers(0, 256, SIZE[::-1], np.uint8)
    left, right = rectifier(rig, SIZE)(image, image)
    assert left is image
    assert right is image


def test_rectified_axes_are_a_rotation_along_the_baseline():
    rig = calibration([0.02, 0.1, -0.05], [-0.2, 0.1, 0.02])
    rotation = common_axes(rig.T_right_left)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    right_eye = -rig.T_right_left[:3, :3].T @ rig.T_right_left[:3, 3]
    np.testing.assert_allclose(rotation @ right_eye, [rig.baseline, 0, 0], atol=1e-12)


def test_swapped_unrectified_cameras_are_rejected():
    with pytest.raises(InputError, match="to the left of the left one"):
        rectifier(calibration([0.01, 0, 0], [0.2, 0, 0]), SIZE)


def test_cameras_without_a_common_view_are_rejected():
    turn = [0, 2.5, 0]
    step = Rotation.from_rotvec(turn).apply([-0.2, 0, 0])  # the right camera is at x = 0.2
    with pytest.raises(InputError, match="share no field of view"):
        rectifier(calibration(turn, step), SIZE)


@pytest.mark.parametrize(
    ("turn", "step", "fault"),
    [
        ([0, 0, 0], [0, 0, -0.2], "look along their baseline"),
        ([0, np.pi / 2, 0], [-0.2, 0, 0], "look too far apart to be rectified"),
    ],
)
def test_cameras_that_cannot_be_rectified_are_rejected(turn, step, fault):
    with pytest.raises(InputError, match=fault):
        rectifier(calibration(turn, step), SIZE)


@pytest.mark.parametrize(("distortion", "is_said"), [(BARREL, False), (1000 * BARREL, True)])
def test_distortion_that_leaves_hardly_any_image_is_reported(distortion, is_said):
    rig = calibration([0.0, 0.0, 0.0], [-0.1, 0.0, 0.0], distortion=np.abs(distortion))
    with collected_notices() as notices:
        rectifier(rig, SIZE)
    assert [one.code for one in notices] == (["calibration-contradictory"] if is_said else [])


@pytest.mark.parametrize(
    ("size", "is_said"), [(SIZE, False), ((480, 360), True), ((200, 160), True)]
)
def test_image_size_is_checked_against_the_principal_point(size, is_said):
    rig = calibration([0.0, 0.0, 0.0], [-0.1, 0.0, 0.0])
    with collected_notices() as notices:
        rectifier(rig, size)
    assert [one.code for one in notices] == (["calibration-off-centre"] if is_said else [])
    sized = replace(rig, left=replace(rig.left, size=SIZE))
    if is_said:
        with pytest.raises(InputError, match="calibration is for"):
            rectifier(sized, size)
