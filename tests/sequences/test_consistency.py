"""Points that several pairs agree on are confirmed; moving or mismatched points are not."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.geometry import pose, transform
from recon.mapping.consistency import Consistency
from recon.records import PointCloud, StereoPair
from tests.sequences.drives import RIG

IMAGE = np.zeros((RIG.height, RIG.width), np.uint8)


def pair_at(z):
    return StereoPair(
        left=IMAGE, right=IMAGE, rig=RIG, T_world_left=pose(np.eye(3), [0, 0, z]), name=f"at {z}"
    )


def seen_from(pair, points_world, rng, sigma_px=0.2):
    """Make the cloud of world points that `pair` measures."""
    points_left = transform(np.linalg.inv(pair.T_world_left), points_world)
    disparity = RIG.disparity(points_left[:, 2]) + rng.normal(0, sigma_px, len(points_left))
    measured = RIG.triangulate(RIG.project_left(points_left), disparity)
    return PointCloud(
        points=transform(pair.T_world_left, measured),
        colours=np.zeros((len(measured), 3), np.uint8),
        sigma=RIG.depth_sigma(points_left[:, 2], np.full(len(measured), sigma_px)),
    )


@pytest.fixture
def rng():
    return np.random.default_rng(4)


@pytest.fixture
def points(rng):
    return rng.uniform([-3, -0.8, 12], [3, 0.8, 20], (300, 3))


def run(places, clouds, **settings):
    consistency = Consistency(**settings)
    settled = []
    for z, cloud in zip(places, clouds, strict=True):
        settled += consistency.add(pair_at(z), cloud)
    return consistency, settled + consistency.finish()


def test_static_points_are_confirmed_by_each_neighbour(rng, points):
    places = [0.0, 0.8, 1.6]
    consistency, settled = run(places, [seen_from(pair_at(z), points, rng) for z in places])
    assert len(settled) == 3
    assert consistency.share > 0.99  # three sigmas
    assert 0 < consistency.median_distance < 0.3


def test_moving_or_mismatched_points_are_not_confirmed(rng, points):
    def cloud_at(number, z):
        moving = points[:100] + np.array([0, 0, 3.0 * number])
        wrong = rng.uniform([-3, -0.8, 5], [3, 0.8, 8], (100, 3))
        return seen_from(pair_at(z), np.concatenate([moving, points[100:200], wrong]), rng)

    places = [0.0, 0.8, 1.6]
    _, settled = run(places, [cloud_at(number, z) for number, z in enumerate(places)])
    for witness in settled:
        moving, still, wrong = witness.is_confirmed.reshape(3, 100).mean(axis=1)
        assert still > 0.97
        assert moving < 0.1
        assert wrong < 0.1


def test_wrong_pose_is_detected(rng, points):
    clouds = [seen_from(pair_at(z), points, rng) for z in (0.0, 0.8)]
    right, _ = run([0.0, 0.8], clouds)
    wrong, _ = run([0.0, 0.8], [clouds[0], clouds[1].transformed(pose(np.eye(3), [0, 0, 4.0]))])
    assert right.share > 0.97
    assert wrong.share < 0.4
    assert wrong.median_distance > 2 * right.median_distance


def test_only_near_points_are_judged(rng, points):
    far = points * [2, 2, 3]
    clouds = [seen_from(pair_at(z), far, rng) for z in (0.0, 0.8)]
    assert run([0.0, 0.8], clouds, max_depth=30.0)[0].share is None
    assert run([0.0, 0.8], clouds, max_depth=100.0)[0].share > 0.97


def test_reach_limits_the_distance_to_neighbours(rng, points):
    half = [points[:150], points[150:], points[:150]]
    clouds = [seen_from(pair_at(0.5 * n), part, rng) for n, part in enumerate(half)]
    places = [0.0, 0.5, 1.0]
    assert run(places, clouds, reach=1)[0].share < 0.2
    assert run(places, clouds, reach=2)[0].share > 0.65


def test_points_behind_the_camera_and_empty_clouds_are_handled(rng, points):
    cloud = seen_from(pair_at(0.0), points, rng)
    nothing = seen_from(pair_at(0.0), points[:0], rng)
    assert run([0.0, 40.0], [cloud, nothing])[0].share == 0.0


def test_pairs_without_a_pose_are_rejected(rng, points):
    pair = StereoPair(left=IMAGE, right=IMAGE, rig=RIG, name="lost")
    with pytest.raises(InputError, match="lost has no pose"):
        Consistency().add(pair, seen_from(pair_at(0.0), points, rng))
