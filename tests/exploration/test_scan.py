"""Obstacles in the field of view, from point clouds."""

from dataclasses import replace

import numpy as np
import pytest

from recon.exploration.floor import Floor
from recon.exploration.scales import Scales
from recon.exploration.scan import detections, scan, without_noise
from recon.records import PointCloud, View
from recon.settings import Settings
from tests.exploration.flatland import HEIGHT, Flatland

PLACE = np.zeros(2)
FLOOR = Floor(size_x=200, size_z=200)
SCALES = Scales.of(Settings())


def cloud(points, sigma=0.1):
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return PointCloud(
        points=points,
        colours=np.zeros((len(points), 3), dtype=np.uint8),
        sigma=np.full(len(points), sigma),
    )


def blob(x, z, number=60, radius=2.0, seed=0):
    offsets = np.random.default_rng(seed).uniform(-radius, radius, (number, 3))
    return np.array([x, HEIGHT, z]) + offsets


def view_towards(x, z):
    return View(position=np.array([0.0, HEIGHT, 0.0]), target=np.array([x, HEIGHT, z]))


def limit_towards(seen, x, z):
    turned = np.angle(np.exp(1j * (seen.azimuths_rad - np.arctan2(z, x))))
    return seen.limits[np.abs(turned).argmin()]


@pytest.fixture
def pair():
    return Flatland(discs=[], settings=Settings()).take(view_towards(20, 0))


def test_single_obstacle_is_found_at_its_position():
    (found,) = detections(cloud(blob(30.0, 10.0)), PLACE, SCALES)
    assert np.hypot(*(found.centre - [30.0, 10.0])) < 1.0
    assert 1.5 < found.radius < 3.5
    assert abs(found.distance - np.hypot(30, 10)) < 1.0


@pytest.mark.parametrize("heading", [0.0, 100.0, 179.0, -135.0])
def test_two_obstacles_are_separated_at_any_heading(heading):
    angle = np.radians(heading)
    ahead, left = np.array([np.cos(angle), np.sin(angle)]), np.radians(20.0)
    near = 20.0 * np.array([np.cos(angle + left), np.sin(angle + left)])
    far, behind = 30.0 * ahead, 70.0 * ahead
    points = np.vstack([blob(*near, seed=1), blob(*far, seed=2), blob(*behind, seed=3)])
    found = sorted(
        detections(cloud(points), PLACE, SCALES), key=lambda detection: detection.distance
    )
    assert len(found) == 3
    for detection, place in zip(found, (near, far, behind), strict=True):
        assert np.hypot(*(detection.centre - place)) < 1.5


def test_few_points_are_not_an_obstacle():
    assert detections(cloud(blob(30.0, 0.0, number=5)), PLACE, SCALES) == []
    assert detections(cloud([]), PLACE, SCALES) == []


def low_table(sigma):
    """Twelve points on a thing 70 units away, spread over the errors of distant points."""
    away = np.repeat([42.0, 58.0, 80.0, 110.0], 3)
    points = np.column_stack([away, np.full(12, HEIGHT), np.linspace(-0.02, 0.02, 12) * away])
    return replace(cloud(points), sigma=sigma * (away / 70.0) ** 2)


def test_few_points_far_away_are_one_obstacle_within_their_errors():
    (found,) = detections(low_table(sigma=15.0), PLACE, SCALES)
    assert 60.0 < found.distance < 80.0
    assert np.allclose(found.azimuth_rad, 0.0, atol=0.02)
    reach = np.hypot(*found.places.T)
    assert reach.min() < 55.0
    assert reach.max() > 95.0


@pytest.mark.parametrize("sigma", [0.0, 0.5])
def test_points_farther_apart_than_their_errors_are_noise(sigma):
    assert detections(low_table(sigma), PLACE, SCALES) == []


def test_isolated_point_is_noise_unlike_a_group():
    kept = without_noise(cloud(np.vstack([blob(30.0, 0.0), [[3.0, HEIGHT, -1.0]]])), PLACE, SCALES)
    assert len(kept) == 60
    assert len(without_noise(cloud([]), PLACE, SCALES)) == 0


def test_rays_end_before_an_obstacle_and_continue_beside_it(pair):
    seen = scan(view_towards(20, 0), pair, cloud(blob(30.0, 0.0)), 60.0, (0.0, 100.0), FLOOR)
    assert 24.0 < limit_towards(seen, 30.0, 0.0) < 30.0
    assert limit_towards(seen, 30.0, 10.0) == limit_towards(seen, 30.0, -10.0) == 60.0


def test_uncertain_obstacle_ends_rays_earlier(pair):
    sure = scan(
        view_towards(20, 0), pair, cloud(blob(30.0, 0.0), sigma=0.1), 60.0, (0.0, 100.0), FLOOR
    )
    unsure = scan(
        view_towards(20, 0), pair, cloud(blob(30.0, 0.0), sigma=6.0), 60.0, (0.0, 100.0), FLOOR
    )
    difference = limit_towards(sure, 30.0, 0.0) - limit_towards(unsure, 30.0, 0.0)
    assert 5.0 < difference < 7.0


def test_obstacles_outside_the_field_of_view_end_no_ray(pair):
    seen = scan(view_towards(20, 0), pair, cloud(blob(-30.0, 0.0)), 60.0, (0.0, 100.0), FLOOR)
    assert (seen.limits == 60.0).all()
