"""Drives that return: loops are found, checked, and remove the drift."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recon.geometry import invert, pose
from recon.localisation.keeper import PlaceKeeper
from recon.localisation.loops import Loop, close_loops, find_loops, optimised
from recon.records import StereoPair, Trajectory
from tests.localisation.recorded import village

NUMBER, RADIUS = 60, 20.0


def round_drive(rng):
    """Make true and drifting poses of a round that starts and ends in view of the village."""
    T_start = village().others[0].T_world_left
    middle = T_start[:3, 3] + RADIUS * T_start[:3, 0]
    true = []
    for angle in np.linspace(0.0, -2.0 * np.pi, NUMBER):
        turn = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
        true.append(pose(turn @ T_start[:3, :3], middle + turn @ (T_start[:3, 3] - middle)))
    drifting = [true[0]]
    for first, second in itertools.pairwise(true):
        error = pose(Rotation.from_rotvec([0.0, 0.004, 0.0]).as_matrix(), rng.normal(0.0, 0.02, 3))
        drifting.append(drifting[-1] @ invert(first) @ second @ error)
    return np.array(true), np.array(drifting)


def with_places(poses):
    """Make an atlas in which the first and last pairs show the same and the others nothing."""
    seen, keeper = village().others[0], PlaceKeeper()
    for number in (0, NUMBER - 1):
        keeper.add(
            StereoPair(left=seen.left, right=seen.right, rig=seen.rig, T_world_left=poses[number]),
            number,
        )
    return keeper.atlas(Trajectory(stamps_s=np.arange(float(NUMBER)), T_world_left=poses))


def test_loop_closure_removes_the_drift_of_odometry():
    true, drifting = round_drive(np.random.default_rng(0))
    closed = close_loops(drifting, with_places(drifting))
    assert closed.num_loops == 1
    assert closed.error_before > 1.0
    assert closed.error_after < 0.1 * closed.error_before
    off = [np.linalg.norm(poses[:, :3, 3] - true[:, :3, 3], axis=1) for poses in
           (drifting, closed.poses)]  # fmt: skip
    assert off[1][-1] < 0.1 * off[0][-1]
    assert off[1].mean() < 0.6 * off[0].mean()
    assert np.allclose(closed.poses[0], drifting[0], atol=1e-9)


def test_straight_drive_has_no_loop():
    _, drifting = round_drive(np.random.default_rng(0))
    straight = drifting.copy()
    straight[:] = drifting[0]
    straight[:, :3, 3] += np.arange(NUMBER)[:, None] * drifting[0][:3, 2]
    assert find_loops(straight, with_places(straight)) == []
    assert close_loops(straight, with_places(straight)) is None


def test_long_drive_is_corrected_by_few_nodes_and_interpolation():
    rng = np.random.default_rng(1)
    poses = np.tile(np.eye(4), (2000, 1, 1))
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    poses[:, 0, 3], poses[:, 2, 3] = 100.0 * np.cos(angle), 100.0 * np.sin(angle)
    true = poses.copy()
    poses[:, :3, 3] += np.cumsum(rng.normal(0.001, 0.01, (2000, 3)), axis=0)
    loop = Loop(
        first=0,
        second=1999,
        T_first_second=invert(true[0]) @ true[-1],
        sigma=(0.002 * 10.0, np.radians(0.05)),
    )
    corrected = optimised(poses, [loop])
    assert loop.error(corrected) < 0.1 * loop.error(poses)
    steps = np.linalg.norm(np.diff(corrected[:, :3, 3], axis=0), axis=1)
    assert steps.max() < 0.6
    assert np.allclose(np.linalg.det(corrected[:, :3, :3]), 1.0)


@pytest.mark.parametrize("number", [0, 1])
def test_drive_with_fewer_than_two_places_has_no_loop(number):
    poses = np.tile(np.eye(4), (number, 1, 1))
    atlas = PlaceKeeper().atlas(Trajectory(stamps_s=np.zeros(number), T_world_left=poses))
    assert find_loops(poses, atlas) == []
