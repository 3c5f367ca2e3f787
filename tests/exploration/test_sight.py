"""Things in the field of view, out of clouds."""

import numpy as np
import pytest

from recon.exploration.sight import look, sightings, without_noise
from recon.records import PointCloud, View
from recon.settings import Settings
from tests.exploration.flatland import HEIGHT, Flatland

PLACE = np.zeros(2)


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


def limit_towards(sight, x, z):
    turned = np.angle(np.exp(1j * (sight.azimuths_rad - np.arctan2(z, x))))
    return sight.limits[np.abs(turned).argmin()]


@pytest.fixture
def pair():
    return Flatland(discs=[], settings=Settings()).take(view_towards(20, 0))


def test_one_thing_is_seen_where_it_is():
    (found,) = sightings(cloud(blob(30.0, 10.0)), PLACE)
    assert np.hypot(*(found.centre - [30.0, 10.0])) < 1.0
    assert 1.5 < found.radius < 3.5
    assert abs(found.distance - np.hypot(30, 10)) < 1.0


@pytest.mark.parametrize("heading", [0.0, 100.0, 179.0, -135.0])
def test_two_things_are_two_whatever_the_heading(heading):
    angle = np.radians(heading)
    ahead, left = np.array([np.cos(angle), np.sin(angle)]), np.radians(20.0)
    near = 20.0 * np.array([np.cos(angle + left), np.sin(angle + left)])
    far, behind = 30.0 * ahead, 70.0 * ahead
    points = np.vstack([blob(*near, seed=1), blob(*far, seed=2), blob(*behind, seed=3)])
    found = sorted(sightings(cloud(points), PLACE), key=lambda sighting: sighting.distance)
    assert len(found) == 3
    for sighting, place in zip(found, (near, far, behind), strict=True):
        assert np.hypot(*(sighting.centre - place)) < 1.5


def test_few_points_are_no_thing():
    assert sightings(cloud(blob(30.0, 0.0, number=5)), PLACE) == []
    assert sightings(cloud([]), PLACE) == []


def test_a_lone_point_is_noise_and_company_is_not():
    kept = without_noise(cloud(np.vstack([blob(30.0, 0.0), [[3.0, HEIGHT, -1.0]]])), PLACE)
    assert len(kept) == 60
    assert len(without_noise(cloud([]), PLACE)) == 0


def test_rays_end_before_a_thing_and_go_on_beside_it(pair):
    sight = look(view_towards(20, 0), pair, cloud(blob(30.0, 0.0)), 60.0)
    assert 24.0 < limit_towards(sight, 30.0, 0.0) < 30.0
    assert limit_towards(sight, 30.0, 10.0) == limit_towards(sight, 30.0, -10.0) == 60.0


def test_an_unsure_thing_ends_rays_earlier(pair):
    sure = look(view_towards(20, 0), pair, cloud(blob(30.0, 0.0), sigma=0.1), 60.0)
    unsure = look(view_towards(20, 0), pair, cloud(blob(30.0, 0.0), sigma=6.0), 60.0)
    difference = limit_towards(sure, 30.0, 0.0) - limit_towards(unsure, 30.0, 0.0)
    assert 5.0 < difference < 7.0


def test_things_outside_the_field_end_no_ray(pair):
    sight = look(view_towards(20, 0), pair, cloud(blob(-30.0, 0.0)), 60.0)
    assert (sight.limits == 60.0).all()
