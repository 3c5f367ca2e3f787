"""Outlines of objects: their edges, occlusion, and merging of adjacent parts."""

import math

import numpy as np
import pytest

from recon.exploration.outlines import outlines
from recon.exploration.scales import Scales
from recon.records import PointCloud
from recon.settings import Settings, explorers

SCALES = Scales.of(explorers(Settings()))
POSE = np.array([3.0, -2.0, 0.7])
HALF_FIELD = math.radians(40.0)


def arc_of_points(azimuth_deg, half_deg, distance, number=400, sigma=0.1):
    """Make points of an object, on an arc around the camera."""
    side = np.radians(np.linspace(azimuth_deg - half_deg, azimuth_deg + half_deg, number))
    x, z = (f(side + POSE[2]) * distance + at for f, at in ((np.cos, POSE[0]), (np.sin, POSE[1])))
    points = np.column_stack([x, np.full(number, 4.0), z])
    return PointCloud(points=points, sigma=np.full(number, sigma))


def seen(*things):
    points = np.vstack([one.points for one in things])
    sigma = np.concatenate([one.sigma for one in things])
    azimuth = np.arctan2(points[:, 2] - POSE[1], points[:, 0] - POSE[0])
    cloud = PointCloud(points=points, sigma=sigma)
    return outlines(cloud, np.column_stack([azimuth] * 2), POSE, HALF_FIELD, SCALES)


def test_separate_objects_show_both_edges():
    near, far = seen(arc_of_points(20.0, 4.0, 60.0, sigma=2.0), arc_of_points(-15.0, 8.0, 20.0))
    assert math.degrees(near.middle_rad) == pytest.approx(-15.0, abs=0.1)
    assert math.degrees(near.half_rad) == pytest.approx(8.0, abs=0.2)
    assert near.distance == pytest.approx(20.0)
    assert math.degrees(far.middle_rad) == pytest.approx(20.0, abs=0.1)
    assert far.sigma == pytest.approx(1.0)
    assert near.is_free.all()
    assert far.is_free.all()


def test_border_of_the_image_hides_an_edge():
    (one,) = seen(arc_of_points(35.0, 5.0, 20.0))
    assert one.is_free.tolist() == [True, False]


def test_nearer_object_hides_an_edge_and_keeps_its_own():
    near, far = seen(arc_of_points(0.0, 4.0, 10.0), arc_of_points(7.0, 4.0, 50.0))
    assert near.is_free.all()
    assert far.is_free.tolist() == [False, True]


def test_adjacent_parts_are_one_outline():
    (one,) = seen(arc_of_points(-4.0, 3.0, 12.0), arc_of_points(4.0, 3.0, 12.5))
    assert np.degrees(one.edges_rad) == pytest.approx([-7.0, 7.0], abs=0.2)
    assert len(seen(arc_of_points(-14.0, 3.0, 12.0), arc_of_points(14.0, 3.0, 12.5))) == 2


def test_few_points_give_no_outline():
    assert seen(arc_of_points(0.0, 1.0, 20.0, number=5)) == []
