"""A pose nearly known becomes precise by corners of the pairs that painted the portrait."""

import numpy as np
import pytest

from recon.geometry import pose, rotation_about_y
from recon.localisation.corners import Corners
from recon.localisation.portrait import Portrait
from recon.localisation.stance import Stance
from recon.records import PoseEstimate, StereoPair
from tests.localisation.trees import off, taken, tree

PAIRS = [taken(degrees) for degrees in range(0, 360, 60)]


@pytest.fixture(scope="module")
def corners():
    stance = Stance.of(np.stack([pair.T_world_left for pair in PAIRS]), 1.0)
    portrait = Portrait.of((tree(),), PAIRS, 1.0)
    return Corners(portrait=portrait, pairs=PAIRS, stance=stance, own=1e-8 * np.eye(6))


def near(pair):
    """The pose of a pair, a third of a unit and a degree off, with its uncertainty."""
    change = pose(rotation_about_y(np.radians(1.0)), [0.25, 0.0, 0.2])
    sigma = np.array([0.001, 0.03, 0.02, 0.4, 0.02, 0.4])
    return PoseEstimate(
        T_world_left=pair.T_world_left @ change, covariance=np.diag(sigma**2), probability=0.99,
        residual=1.0, inlier_share=0.9, num_cells=900,
    )  # fmt: skip


def test_a_pose_nearly_known_becomes_precise(corners):
    pair = taken(30)
    found = corners.refined(pair, near(pair))
    assert off(found.T_world_left, pair) < min(0.15, 4.0 * found.sigma)
    assert found.sigma < 0.5 * near(pair).sigma
    assert found.probability == 0.99


def test_an_image_of_something_else_changes_nothing(corners):
    pair = taken(30)
    blank = np.full_like(pair.left, 128)
    other = StereoPair(left=blank, right=blank, rig=pair.rig)
    assert (corners.refined(other, near(pair)).T_world_left == near(pair).T_world_left).all()


def test_corners_less_precise_than_the_pose_change_nothing(corners):
    pair = taken(30)
    known = PoseEstimate(
        T_world_left=pair.T_world_left, covariance=1e-8 * np.eye(6), probability=0.99,
        residual=1.0, inlier_share=0.9, num_cells=900,
    )  # fmt: skip
    assert (corners.refined(pair, known).T_world_left == known.T_world_left).all()
