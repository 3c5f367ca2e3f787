"""Texture tells the sides of a round tree apart, and the pose of a pair beside it."""

import numpy as np
import pytest

from recon.geometry import invert, pose, rotation_about_y
from recon.localisation.inspection import measured_from
from recon.localisation.registration import Points
from recon.localisation.texture import Screen, Texture
from recon.localisation.turns import Turns
from recon.records import StereoPair
from tests.localisation.trees import off, taken, tree, turned

NOTHING = Points(points_left=np.zeros((0, 3)), sigma=np.zeros(0), across=np.zeros(0))


@pytest.fixture(scope="module")
def turns():
    pairs = [taken(degrees) for degrees in range(0, 360, 60)]
    return Turns(texture=Texture.of((tree(),), pairs, 1.0), pairs=pairs)


@pytest.fixture(scope="module")
def clear():
    return Screen.of(NOTHING, taken(30).rig)


def test_texture_is_that_of_the_true_side(turns, clear):
    pair = taken(30)
    evidence = [
        turns.texture.evidence(pair, clear, turned(pair.T_world_left, degrees))
        for degrees in range(0, 360, 10)
    ]
    assert evidence[0] > 10.0
    assert max(evidence[1:]) < 0.5 * evidence[0]


def test_usual_colours_are_the_same_on_all_sides(turns, clear):
    pair = taken(30)
    fit = turns.texture.fit
    sides = [fit(pair, clear, turned(pair.T_world_left, degrees)) for degrees in range(0, 360, 60)]
    tilted = pair.T_world_left @ pose(rotation_about_y(0.0), [0.0, 3.0, 0.0])
    assert min(sides) > -1.5
    assert fit(pair, clear, tilted) < min(sides) - 0.3


def test_other_colours_count_against_a_pose(turns, clear):
    pair = taken(30)
    other = StereoPair(left=255 - pair.left, right=255 - pair.right, rig=pair.rig)
    assert turns.texture.evidence(other, clear, pair.T_world_left) < -5.0


def test_what_is_hidden_by_something_nearer_says_nothing(turns):
    pair = taken(30)
    v, u = np.mgrid[0 : pair.rig.height : 4, 0 : pair.rig.width : 4]
    wall = 5.0 * pair.rig.rays(np.column_stack([u.ravel(), v.ravel()]))
    points = Points(points_left=wall, sigma=np.full(len(wall), 0.1), across=np.zeros(len(wall)))
    screen = Screen.of(points, pair.rig)
    assert turns.texture.evidence(pair, screen, pair.T_world_left) == 0.0


def test_pose_is_found_from_any_other_side_of_the_tree(turns, clear):
    pair = taken(30)
    found = turns.around(pair, clear, turned(pair.T_world_left, 97.0))
    assert off(found[0], pair) < 1.0
    met = turns.measured(pair, found[0])
    estimates = [measured_from(*one, pair.rig, 1e-6 * np.eye(6)) for one in met]
    assert estimates
    for one in estimates:
        assert off(one.T_world_left, pair) < min(0.5, 4.0 * one.sigma)
        assert one.inlier_share > 0.5


def test_corners_of_another_side_do_not_agree(turns):
    pair = taken(30)
    assert turns.measured(pair, turned(pair.T_world_left, 90.0)) == []


def test_nothing_is_turned_about_if_nothing_is_in_view(turns, clear):
    pair = taken(30)
    away = invert(pose(np.diag([-1.0, 1.0, -1.0]), np.zeros(3)))
    assert turns.around(pair, clear, pair.T_world_left @ away) == []
