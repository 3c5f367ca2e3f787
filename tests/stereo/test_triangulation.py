"""Points are triangulated at their positions, with colour and the sigma of their depth."""

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.records import Matches, StereoPair
from recon.settings import TriangulationSettings
from recon.stereo.triangulation import triangulate

RIG = StereoRig(
    width=64, height=48, focal_px=50.0, cx_left_px=31.5, cx_right_px=31.5, cy_px=23.5, baseline=0.3
)


def matches_of(points_px, disparity_px, sigma_px=0.1):
    number = len(points_px)
    return Matches(
        points_px=np.asarray(points_px, dtype=float),
        disparity_px=np.asarray(disparity_px, dtype=float),
        sigma_px=np.full(number, sigma_px),
        score=np.linspace(1, 0.5, number),
        index_left=np.arange(number, dtype=np.int32),
        index_right=np.full(number, -1, np.int32),
    )


def pair_of(left):
    return StereoPair(left=left, right=left, rig=RIG)


def test_known_point_is_recovered():
    point = np.array([[0.4, -0.2, 3.0]])
    matches = matches_of(RIG.project_left(point), RIG.disparity(point[:, 2]))
    image = np.zeros((48, 64, 3), np.uint8)
    image[..., 0] = 200
    cloud = triangulate(matches, pair_of(image), TriangulationSettings()).sure
    np.testing.assert_allclose(cloud.points, point, atol=1e-12)
    np.testing.assert_allclose(cloud.sigma, 3.0**2 / (50 * 0.3) * 0.1)
    assert cloud.colours.tolist() == [[200, 0, 0]]


def test_disparity_noise_gives_the_sigma_of_depth():
    rng = np.random.default_rng(0)
    depth, sigma_px = 3.0, 0.05
    noisy = RIG.disparity(depth) + rng.normal(0, sigma_px, 4000)
    matches = matches_of(np.tile([31.5, 23.5], (4000, 1)), noisy, sigma_px)
    cloud = triangulate(
        matches, pair_of(np.zeros((48, 64), np.uint8)), TriangulationSettings()
    ).sure
    assert 0.9 < np.std(cloud.points[:, 2]) / np.median(cloud.sigma) < 1.1


@pytest.mark.parametrize("disparity", [0.0, -2.0, np.nan])
def test_points_without_an_intersection_in_front_are_left_out(disparity):
    matches = matches_of([[10, 10], [20, 20]], [5.0, disparity])
    cloud = triangulate(
        matches, pair_of(np.zeros((48, 64), np.uint8)), TriangulationSettings()
    ).sure
    assert len(cloud) == 1


def test_uncertain_points_are_left_out_on_request():
    matches = matches_of([[10, 10], [20, 20]], [5.0, 1.0])
    image = np.zeros((48, 64), np.uint8)
    sure = triangulate(matches, pair_of(image), TriangulationSettings(max_sigma=0.5)).sure
    assert len(sure) == 1
    assert sure.points[0, 2] == pytest.approx(3.0)


def test_colour_is_the_mean_of_the_window_even_at_the_border():
    image = np.zeros((48, 64), np.uint8)
    image[10, 10] = 90
    matches = matches_of([[10, 10], [0, 0]], [5.0, 5.0])
    cloud = triangulate(matches, pair_of(image), TriangulationSettings(colour_window_px=3)).sure
    assert cloud.colours.tolist() == [[10, 10, 10], [0, 0, 0]]


def test_no_matches_give_an_empty_cloud():
    image = np.zeros((48, 64), np.uint8)
    assert len(triangulate(Matches.none(), pair_of(image), TriangulationSettings()).sure) == 0
