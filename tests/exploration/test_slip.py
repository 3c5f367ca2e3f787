"""Motion errors: the believed pose, the true pose, and the referee's measurements."""

import math

import numpy as np
import pytest

from recon.exploration.referee import Referee
from recon.exploration.slip import Slip, slip_of
from recon.geometry import invert, look_at
from recon.records import Trajectory, View
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland


def slipping(position=0.1, heading_deg=1.0, seed=0):
    motion = {"position_noise": position, "heading_noise_deg": heading_deg, "noise_seed": seed}
    return updated(Settings(), {"motion": motion})


def slip_with(**parts):
    settings = slipping()
    world = Flatland(discs=[(0.0, -8.0, 3.0, 12.0)], settings=settings)
    return Slip(referee=Referee(world=world, settings=settings), **parts)


def ahead(x=0.0, z=0.0):
    return View(position=np.array([x, 5.0, z]), target=np.array([x, 5.0, z - 10.0]))


def test_motion_errors_have_the_stated_spread_and_accumulate():
    slip = slip_with(motion=slipping(0.1, 2.0).motion)
    steps = []
    for _ in range(2000):
        before = slip.T_true_believed
        slip.err(np.array([[0.0, 5.0, 0.0], [0.0, 5.0, 0.0]]))
        steps.append(invert(before) @ slip.T_true_believed)
    shifts = np.array([T @ [0.0, 5.0, 0.0, 1.0] for T in steps])[:, [0, 2]]
    turns = np.degrees([math.asin(T[0, 2]) for T in steps])
    assert 0.095 < shifts.std() < 0.105
    assert 1.9 < turns.std() < 2.1
    assert np.abs(shifts.mean()) < 0.01


def test_heading_error_deflects_a_step():
    slip = slip_with(motion=slipping(0.0, 0.0).motion, T_true_believed=turned(0.1))
    true = slip.err(np.array([[0.0, 5.0, 0.0], [0.0, 5.0, -20.0]]))
    assert true[-1] == pytest.approx([-20.0 * math.sin(0.1), 5.0, -20.0 * math.cos(0.1)])


def turned(angle):
    from recon.geometry import pose, rotation_about_y

    return pose(rotation_about_y(angle), np.zeros(3))


def test_correction_changes_the_belief_but_not_the_robot():
    slip = slip_with(motion=slipping().motion, T_true_believed=turned(0.2))
    T_new_old, view = turned(-0.05), ahead(3.0, 4.0)
    where = slip.true_view(view)
    slip.correct(T_new_old)
    moved = (T_new_old @ np.append(view.position, 1.0))[:3]
    still = slip.true_view(View(position=moved, target=moved + np.array([0.0, 0.0, 1.0])))
    assert still.position == pytest.approx(where.position)


def test_pose_error_is_the_difference_of_belief_and_truth():
    believed = look_at([0.0, 5.0, 0.0], [0.0, 5.0, -1.0])
    slip = slip_with(motion=slipping().motion)
    slip.true_poses.append(look_at([0.3, 5.0, 0.4], [1.3, 5.0, 0.4]))
    path = Trajectory(stamps_s=np.zeros(1), T_world_left=believed[None])
    errors = slip.errors(path)
    assert errors == pytest.approx({"pose_error_end": 0.5, "pose_error_end_deg": 90.0})
    assert slip.errors(path.__class__(stamps_s=np.zeros(0), T_world_left=np.zeros((0, 4, 4)))) == {
        "pose_error_end": None,
        "pose_error_end_deg": None,
    }


def test_collision_stops_the_robot_and_is_reported_in_believed_coordinates():
    slip = slip_with(motion=slipping().motion, T_true_believed=turned(0.2))
    contact = slip.walk(np.array([[0.0, 5.0, 0.0], [2.0, 5.0, -10.0]]))
    true = turned(0.2) @ [contact[0], 0.0, contact[1], 1.0]
    assert 3.0 < math.hypot(true[0], true[2] + 8.0) < 3.6
    assert np.array_equal(slip.T_true_believed, turned(0.2))
    assert slip.walk(np.array([[0.0, 5.0, 0.0], [0.0, 5.0, 10.0]])) is None
    assert slip.referee.min_clearance < 9.0


def test_motion_errors_need_known_truth_and_a_setting():
    referee = slip_with(motion=slipping().motion).referee
    assert slip_of(referee, slipping()) is not None
    assert slip_of(referee, Settings()) is None
    assert slip_of(None, slipping()) is None
