"""Rims: the silhouettes beside the points of a pair."""

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.exploration.rims import rims
from recon.geometry import pose, rotation_about_y
from recon.records import PointCloud, StereoPair

RIG = StereoRig(
    width=80, height=40, focal_px=50.0, cx_left_px=39.5, cy_px=19.5, cx_right_px=39.5, baseline=0.3
)
TURN = 0.4
T_WORLD_LEFT = pose(rotation_about_y(TURN), np.array([3.0, 1.0, -2.0]))


def taken(left_px, right_px, contrast):
    """Render a bar between two fractional columns, and two points within it."""
    column = np.arange(RIG.width)
    share = np.clip(column + 0.5 - left_px, 0, 1) * np.clip(right_px - column + 0.5, 0, 1)
    image = np.broadcast_to(200.0 - contrast * share, (RIG.height, RIG.width)).astype(np.uint8)
    points = RIG.triangulate([[32.0, 20.0], [48.0, 20.0]], [1.0, 1.0])
    world = points @ T_WORLD_LEFT[:3, :3].T + T_WORLD_LEFT[:3, 3]
    pair = StereoPair(left=image, right=image, rig=RIG, T_world_left=T_WORLD_LEFT)
    return rims(PointCloud(points=world), pair)


def column_of(azimuth):
    return RIG.cx_left_px + RIG.focal_px * np.tan(np.pi / 2 - TURN - azimuth)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.8])
def test_edges_of_a_bar_are_found_with_sub_pixel_accuracy(part):
    found = column_of(taken(29.0 + part, 50.0 + part, 150.0))
    assert sorted(found[0]) == pytest.approx([29.0 + part, 32.0], abs=0.2)
    assert sorted(found[1]) == pytest.approx([48.0, 50.0 + part], abs=0.2)


def test_point_without_a_near_edge_is_its_own_rim():
    own = [[32.0, 32.0], [48.0, 48.0]]
    assert np.allclose(column_of(taken(20.0, 60.0, 150.0)), own)
    assert np.allclose(column_of(taken(29.0, 50.0, 5.0)), own)
