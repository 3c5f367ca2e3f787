"""A rectified rig: projection, triangulation, and the effect of wrong conventions."""

from dataclasses import replace

import numpy as np
import pytest

from recon.camera import TYPICAL_RESIDUAL_PX, StereoRig
from recon.errors import InputError
from recon.geometry import invert, transform

RIG = StereoRig(
    width=320, height=240, focal_px=300.0, cx_left_px=170.0, cx_right_px=150.0, cy_px=110.0,
    baseline=0.25,
)  # fmt: skip


@pytest.fixture
def points_left():
    rng = np.random.default_rng(3)
    return np.column_stack(
        [rng.uniform(-2, 2, 200), rng.uniform(-1, 1, 200), rng.uniform(2, 20, 200)]
    )


def observe(points_left):
    left, right = RIG.project_left(points_left), RIG.project_right(points_left)
    return left, left[:, 0] - right[:, 0]


def test_residual_must_be_a_non_negative_number():
    assert RIG.residual_px == TYPICAL_RESIDUAL_PX
    assert replace(RIG, residual_px=0.0) != RIG
    for wrong in (-0.1, np.nan, None):
        with pytest.raises(InputError, match=r"rig residual_px is .*, but a number >= 0"):
            replace(RIG, residual_px=wrong)


def test_projection_and_triangulation_are_inverse(points_left):
    left_px, disparity_px = observe(points_left)
    np.testing.assert_allclose(RIG.triangulate(left_px, disparity_px), points_left, atol=1e-12)
    np.testing.assert_allclose(RIG.disparity(points_left[:, 2]), disparity_px, atol=1e-12)


def test_points_have_equal_rows_in_both_images(points_left):
    assert np.array_equal(RIG.project_left(points_left)[:, 1], RIG.project_right(points_left)[:, 1])


@pytest.mark.parametrize("mistake", ["u and v swapped", "left and right swapped", "half pixel"])
def test_every_wrong_convention_misplaces_the_points(points_left, mistake):
    left_px, disparity_px = observe(points_left)
    if mistake == "u and v swapped":
        wrong = RIG.triangulate(left_px[:, ::-1], disparity_px)
        assert np.median(np.linalg.norm(wrong - points_left, axis=1)) > 0.5
    elif mistake == "left and right swapped":
        assert np.isnan(RIG.triangulate(left_px, -disparity_px + 0.0)).any()
    else:
        wrong = RIG.triangulate(left_px + 0.5, disparity_px)
        assert 1e-3 < np.median(np.linalg.norm(wrong - points_left, axis=1)) < 0.1


def test_right_camera_is_one_baseline_along_x(points_left):
    points_right = transform(invert(RIG.T_left_right), points_left)
    u = RIG.focal_px * points_right[:, 0] / points_right[:, 2] + RIG.cx_right_px
    np.testing.assert_allclose(u, RIG.project_right(points_left)[:, 0], atol=1e-12)


def test_depth_is_unknown_if_rays_do_not_intersect():
    assert np.isnan(RIG.depth([RIG.disparity_offset_px, RIG.disparity_offset_px - 1, np.nan])).all()
    assert RIG.depth(RIG.disparity_offset_px + 75.0) == 1.0


@pytest.mark.parametrize("depth", [3.0, 8.0, 15.0])
def test_depth_noise_follows_from_disparity_noise(depth):
    rng = np.random.default_rng(4)
    disparity_px = RIG.disparity(depth) + rng.normal(0, 0.05, 20_000)
    ratio = RIG.depth(disparity_px).std() / RIG.depth_sigma(depth, 0.05)
    assert 0.9 < ratio < 1.1


def test_invalid_number_of_a_rig_is_named():
    with pytest.raises(InputError, match="rig baseline is -1"):
        replace(RIG, baseline=-1.0)
    with pytest.raises(InputError, match="rig cy_px is nan"):
        replace(RIG, cy_px=float("nan"))
