"""Errors of recorded poses are estimated from places that show the same."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from recon.geometry import pose
from recon.localisation.atlas import Atlas
from recon.localisation.place_errors import PlaceErrors
from tests.localisation.recorded import village

TURN, SHIFT = 0.03, 1.0


def disturbed(rng, atlas):
    """The atlas with errors of all its poses."""
    turns = Rotation.from_rotvec(rng.normal(0.0, TURN, (len(atlas), 3))).as_matrix()
    shifts = rng.normal(0.0, SHIFT, (len(atlas), 3))
    errors = np.array([pose(turn, shift) for turn, shift in zip(turns, shifts, strict=True)])
    return replace(atlas, T_world_left=atlas.T_world_left @ errors)


def test_exact_poses_have_hardly_any_errors():
    errors = PlaceErrors.of(village().atlas, 1.0)
    assert errors.turn < 0.2 * TURN
    assert errors.shift < 0.2 * SHIFT


def test_errors_of_poses_are_recovered():
    rng, atlas = np.random.default_rng(0), village().atlas
    found = [PlaceErrors.of(disturbed(rng, atlas), 1.0) for _ in range(12)]
    assert 0.7 < np.mean([one.turn for one in found]) / TURN < 1.4
    assert 0.7 < np.mean([one.shift for one in found]) / SHIFT < 1.4


def test_a_lone_place_has_the_least_errors():
    one = Atlas(places=village().atlas.places[:1], numbers=[0], T_world_left=np.eye(4)[None])
    assert np.isclose(PlaceErrors.of(one, 2.0).shift, 0.02)
    assert (np.diag(PlaceErrors.of(one, 2.0).covariance) > 0.0).all()


def test_other_places_that_look_alike_are_no_errors_of_poses():
    atlas = village().atlas
    moved = atlas.T_world_left.copy()
    moved[1::2, 0, 3] += 100.0
    errors = PlaceErrors.of(replace(atlas, T_world_left=moved), 1.0)
    assert errors.shift < 0.2 * SHIFT
