"""The pose of a pair near a guess: recovered, with a consistent covariance."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import recon
from recon.geometry import invert, look_at, pose, transform
from recon.localisation.locate import locate_points, prior_of
from recon.localisation.registration import Points
from recon.localisation.surfels import Surfels
from recon.records import FitFailure, PointCloud, PoseEstimate
from recon.voxelmap import VoxelMap
from tests.localisation.recorded import SETTINGS, village

SIGMA, ACROSS = 0.15, 0.03


def corner(rng, number):
    """Sample points on the ground and two walls of a room, in the world frame."""
    a, b = rng.uniform(0.0, 8.0, (2, number))
    zero = np.zeros(number)
    walls = [np.column_stack([a, b, zero]), np.column_stack([zero, a, b])]
    return np.vstack([*walls, np.column_stack([a, zero, b])])


def measured_room(rng, T_world_left):
    """Measure the room with a pair at a pose."""
    points = transform(invert(T_world_left), corner(rng, 150))
    depth = points[:, 2:]
    noisy = points * (1.0 + SIGMA * rng.normal(size=depth.shape) / depth)
    noisy += ACROSS * rng.normal(size=points.shape)
    number = len(points)
    return Points(points_left=noisy, sigma=np.full(number, SIGMA), across=np.full(number, ACROSS))


@pytest.fixture(scope="module")
def room():
    voxel_map = VoxelMap(0.5)
    points = corner(np.random.default_rng(0), 20000)
    voxel_map.insert(PointCloud(points=points, colours=np.zeros(points.shape, np.uint8)))
    return Surfels.of(voxel_map.occupied(3))


T_TRUE = look_at([6.0, 4.0, 7.0], [1.0, 2.0, 1.0])


def guess_near(rng):
    turn = Rotation.from_rotvec(rng.normal(0.0, 0.03, 3)).as_matrix()
    return pose(turn @ T_TRUE[:3, :3], T_TRUE[:3, 3] + rng.normal(0.0, 0.2, 3))


def test_pose_is_recovered_and_the_covariance_is_consistent(room):
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(40):
        found = locate_points(measured_room(rng, T_TRUE), room, prior_of(guess_near(rng), 0.5))
        assert isinstance(found, PoseEstimate)
        turn = found.T_world_left[:3, :3] @ T_TRUE[:3, :3].T
        shift = found.T_world_left[:3, 3] - T_TRUE[:3, 3]
        off = np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift])
        ratios.append(off @ np.linalg.inv(found.covariance) @ off / 6.0)
        assert np.linalg.norm(shift) < 0.2
        assert found.inlier_share > 0.9
    assert 0.4 < np.sqrt(np.mean(ratios)) < 1.4


def test_floor_alone_leaves_the_horizontal_position_uncertain(room):
    rng = np.random.default_rng(2)
    points = measured_room(rng, T_TRUE)
    world = transform(T_TRUE, points.points_left)
    on_floor = (np.abs(world[:, 1]) < 0.3) & (world[:, [0, 2]].min(axis=1) > 1.5)
    floor = Points(**{n: getattr(points, n)[on_floor] for n in Points.__slots__})
    found = locate_points(floor, room, prior_of(guess_near(rng), 0.5))
    sigma = np.sqrt(np.diag(found.covariance))[3:]
    assert sigma[1] < 0.1
    assert min(sigma[[0, 2]]) > 0.3


def test_pair_outside_the_map_is_not_located(room):
    rng = np.random.default_rng(3)
    points = measured_room(rng, T_TRUE)
    away = pose(T_TRUE[:3, :3], T_TRUE[:3, 3] + [100.0, 0.0, 0.0])
    assert locate_points(points, room, prior_of(away, 0.5)).reason.startswith("too few points")
    few = Points(**{n: getattr(points, n)[:5] for n in Points.__slots__})
    assert "5 points" in locate_points(few, room, prior_of(T_TRUE, 0.5)).reason
    empty = Surfels.of(VoxelMap(0.5).occupied())
    assert locate_points(points, empty, prior_of(T_TRUE, 0.5)).reason == "the map is empty"


def test_pair_is_located_in_a_map_of_other_pairs():
    pair = village().others[1]
    T_true = pair.T_world_left
    guess = pose(T_true[:3, :3], T_true[:3, 3] + [0.5, 0.0, -0.5])
    found = recon.locate(pair, village().voxels, guess, SETTINGS)
    half_a_cell = 0.5 * SETTINGS.map.cell_size
    assert np.linalg.norm(found.T_world_left[:3, 3] - T_true[:3, 3]) < half_a_cell
    better = recon.locate(pair, village().voxels, found, SETTINGS)
    assert better.sigma < found.sigma
    assert isinstance(recon.locate(pair, VoxelMap(1.0), guess, SETTINGS), FitFailure)


def test_invalid_arguments_of_locate_are_rejected():
    pair = village().others[0]
    with pytest.raises(recon.InputError, match="guess"):
        recon.locate(pair, village().voxels, np.zeros((4, 4)))
    with pytest.raises(recon.InputError, match="pair is of type str"):
        recon.locate("pair", village().voxels, np.eye(4))
