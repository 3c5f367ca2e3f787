"""Clouds in any frame: levelled, segmented, and transformed back."""

import dataclasses

import numpy as np
import pytest

from recon.errors import InputError
from recon.geometry import pose, transform
from recon.recognition.clouds import T_LEVEL_CLOUD, recognise_cloud
from recon.recognition.frames import moved
from recon.recognition.synthetic import Orbit, observe, random_composite
from recon.records import Box, Cone, Cylinder, PointCloud, Sphere
from recon.settings import RecognitionSettings

SETTINGS = RecognitionSettings()


def village(surfaces, seed=0):
    """Make a cottage and an apple tree on textured ground, y up."""
    rng = np.random.default_rng(seed)
    clouds = []
    for kind, place in (("cottage", [-15.0, 0.0]), ("apple tree", [15.0, 5.0])):
        composite = dataclasses.replace(random_composite(kind, rng), axis=np.array(place))
        clouds.append(observe(composite, np.full((2, 3), 120.0), Orbit(sigma_px=0.03), rng).points)
    ground = rng.uniform(-35, 35, (9000, 3)) * [1.0, 0.0, 1.0] + rng.normal(0, 0.05, (9000, 3))
    points = np.concatenate([*clouds, ground])
    return PointCloud(points=points, colours=np.full(points.shape, 120, np.uint8))


def named(recognition):
    return sorted(one.label for one in recognition.objects if one.num_voxels > 60)


@pytest.mark.parametrize("up", ["y", "-y", "z", "-z"])
def test_up_axis_and_tilt_do_not_matter(surfaces, up):
    cloud = village(surfaces)
    angle = np.radians(25.0)
    tilt = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    T_cloud_level = np.linalg.inv(T_LEVEL_CLOUD[up]) @ pose(tilt, [3.0, 90.0, -7.0])
    found = recognise_cloud(cloud.transformed(T_cloud_level), SETTINGS, up)
    assert named(found) == ["apple tree", "cottage"]
    cottage = next(one for one in found.objects if one.label == "cottage")
    place = transform(np.linalg.inv(T_cloud_level), cottage.centre[None])[0]
    assert place[::2] == pytest.approx([-15.0, 0.0], abs=0.3)
    body = cottage.parts[0].solid
    assert abs(body.axis @ T_cloud_level[:3, 1]) == pytest.approx(1.0, abs=1e-3)


def test_wrong_up_axis_finds_no_trees(surfaces):
    assert named(recognise_cloud(village(surfaces), SETTINGS, "-y")) != ["apple tree", "cottage"]


def test_labels_refer_to_the_points(surfaces):
    cloud = village(surfaces)
    found = recognise_cloud(cloud, SETTINGS)
    assert found.label.shape == (len(cloud),)
    cottage = next(one for one in found.objects if one.label == "cottage")
    own = cloud.points[found.label == cottage.id]
    assert np.hypot(*(own[:, ::2] - [-15.0, 0.0]).T).max() < 12
    assert (found.label[-9000:] == -1).mean() > 0.95


def test_unknown_up_axis_is_rejected():
    cloud = PointCloud(points=np.zeros((1, 3)), colours=np.zeros((1, 3), np.uint8))
    with pytest.raises(InputError, match="up is 'x', but one of y, -y, z, -z is needed"):
        recognise_cloud(cloud, SETTINGS, "x")


@pytest.mark.parametrize(
    "points",
    [
        np.empty((0, 3)),
        np.zeros((1, 3)),
        np.zeros((5000, 3)),
        np.outer(np.linspace(0, 9, 500), [1.0, 1.0, 1.0]),
        np.random.default_rng(0).uniform(size=(500, 3)) * [9, 0, 9],
        np.full((50, 3), np.nan),
        np.append(np.random.default_rng(0).uniform(size=(500, 3)), [[1e12, 1e12, 1e12]], axis=0),
    ],
    ids=["empty", "one", "duplicates", "line", "plane", "nan", "far"],
)
def test_degenerate_clouds_hold_no_known_objects(points):
    cloud = PointCloud(points=points, colours=np.zeros(points.shape, np.uint8))
    found = recognise_cloud(cloud, SETTINGS)
    assert {one.label for one in found.objects} <= {"unknown"}
    assert found.label.shape == (len(points),)


def test_solids_are_transformed_with_their_frame():
    rng = np.random.default_rng(0)
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    T = pose(q if np.linalg.det(q) > 0 else -q, [1.0, 2.0, 3.0])
    axis = np.array([0.6, 0.0, 0.8])
    points = rng.uniform(-3, 3, (50, 3))
    for solid in (
        Sphere(centre=np.ones(3), radius=0.5),
        Cylinder(point=np.ones(3), axis=axis, radius=0.5, height=1.0),
        Cone(apex=np.ones(3), axis=axis, half_angle_rad=0.4, height=1.0),
        Box(centre=np.ones(3), axes=np.eye(3), sizes=np.array([1.0, 2.0, 3.0])),
    ):
        there = moved(solid, T).distances(transform(T, points))
        np.testing.assert_allclose(there, solid.distances(points), atol=1e-12)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "ids"), [("mosd_learn5", [20, 30]), ("mosd_test31", [20, 30, 40])]
)
def test_objects_on_a_table_are_separated(data_dir, name, ids):
    archive = np.load(data_dir / "pointclouds" / name / "cloud.npz")
    truth = archive["label"]
    cloud = PointCloud(points=archive["xyz"].astype(float), colours=archive["rgb"])
    found = recognise_cloud(cloud, SETTINGS, "-y")
    for number in ids:
        overlap = [
            ((found.label == one.id) & (truth == number)).sum()
            / ((found.label == one.id) | (truth == number)).sum()
            for one in found.objects
        ]
        assert max(overlap) > 0.8
