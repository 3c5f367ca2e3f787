"""Rigid motions and angles: axioms, round trips, conventions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import (
    check_rigid,
    hue_distance_deg,
    invert,
    look_at,
    pose,
    rotation_about_y,
    transform,
)

ANGLES = [0.0, 1e-7, 0.5, np.pi - 1e-7, np.pi]


def random_pose(rng, angle=None):
    vector = rng.normal(size=3)
    if angle is not None:
        vector *= angle / np.linalg.norm(vector)
    return pose(Rotation.from_rotvec(vector).as_matrix(), rng.normal(size=3) * 10)


@pytest.mark.parametrize("angle", ANGLES)
def test_pose_times_its_inverse_is_the_identity(angle):
    T = random_pose(np.random.default_rng(1), angle)
    np.testing.assert_allclose(T @ invert(T), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(invert(invert(T)), T, atol=1e-12)


def test_only_inner_frame_names_cancel():
    rng = np.random.default_rng(2)
    T_a_b, T_b_c, points_c = random_pose(rng), random_pose(rng), rng.normal(size=(50, 3))
    by_steps = transform(T_a_b, transform(T_b_c, points_c))
    np.testing.assert_allclose(transform(T_a_b @ T_b_c, points_c), by_steps, atol=1e-12)
    wrong = transform(T_b_c @ T_a_b, points_c)
    assert np.linalg.norm(wrong - by_steps, axis=1).min() > 0.1


def test_transform_keeps_its_input_and_names_wrong_shapes():
    points = np.ones((4, 3))
    points.flags.writeable = False
    transform(np.eye(4), points)
    with pytest.raises(InputError, match=r"points_b has shape \(4, 2\), but \(N, 3\) is needed"):
        transform(np.eye(4), np.ones((4, 2)))


@given(st.tuples(*[st.floats(-50, 50)] * 6))
@settings(max_examples=50)
def test_look_at_puts_the_target_straight_ahead(numbers):
    eye, target = np.array(numbers[:3]), np.array(numbers[3:])
    if np.hypot(*(target - eye)[[0, 2]]) < 1e-3:
        return
    T_world_cam = look_at(eye, target)
    check_rigid("T_world_cam", T_world_cam)
    ahead = transform(invert(T_world_cam), target[None])[0]
    np.testing.assert_allclose(ahead, [0, 0, np.linalg.norm(target - eye)], atol=1e-9)


def test_y_is_up_in_the_world_and_down_in_the_image():
    T_world_cam = look_at([0, 5, 0], [0, 5, -10])
    np.testing.assert_allclose(T_world_cam[:3, 0], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(T_world_cam[:3, 1], [0, -1, 0], atol=1e-12)
    upside_down = look_at([0, 5, 0], [0, 5, -10], up=(0, -1, 0))
    assert upside_down[1, 1] > 0.99


def test_look_at_rejects_a_target_straight_above():
    with pytest.raises(InputError, match="no horizontal direction"):
        look_at([1, 2, 3], [1, 9, 3])


def test_rotation_about_y_is_counter_clockwise_from_above():
    turned = rotation_about_y(np.pi / 2) @ [0, 0, -1]
    np.testing.assert_allclose(turned, [-1, 0, 0], atol=1e-12)


def test_check_rigid_rejects_scale_reflection_and_nan():
    for broken in (np.diag([2.0, 2, 2, 1]), np.diag([-1.0, 1, 1, 1]), np.full((4, 4), np.nan)):
        with pytest.raises(InputError):
            check_rigid("T", broken)


def test_hue_is_cyclic():
    np.testing.assert_allclose(hue_distance_deg([350, 10, 0], [10, 350, 180]), [20, 20, 180])
