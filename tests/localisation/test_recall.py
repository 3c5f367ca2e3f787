"""The kidnapped robot: pairs are recalled in a map, or reported as unknown."""

from dataclasses import replace

import numpy as np
import pytest

from recon.errors import InputError
from recon.localisation.atlas import Atlas
from recon.localisation.recall import Hypothesis, KnownWorld, choose
from recon.localisation.trust import trust_in
from recon.records import FitFailure, PoseEstimate, StereoPair
from tests.localisation.recorded import SETTINGS, village


def error(found, pair):
    return float(np.linalg.norm(found.T_world_left[:3, 3] - pair.T_world_left[:3, 3]))


@pytest.fixture(scope="module")
def known():
    recorded = village()
    return KnownWorld.of(recorded.voxels, recorded.atlas, SETTINGS)


def test_pairs_of_a_mapped_round_are_recalled_and_none_is_misplaced(known):
    pairs = village().others[1::2]
    found = [(known.recall(pair), pair) for pair in pairs]
    assert sum(error(one, pair) < 0.3 for one, pair in found if one) >= len(pairs) // 2
    assert all(error(one, pair) < 3.0 * one.sigma for one, pair in found if one)
    assert all(one.probability > 0.9 and one.sigma < 0.5 for one, _ in found if one)


def test_blank_pair_is_not_recalled(known):
    pair = village().others[0]
    blank = np.full_like(pair.left, 128)
    found = known.recall(StereoPair(left=blank, right=blank, rig=pair.rig))
    assert isinstance(found, FitFailure)
    assert found.reason == "too little is seen"


def hypothesis_at(x, same, different, is_known=True):
    T = np.eye(4)
    T[0, 3] = x
    estimate = PoseEstimate(
        T_world_left=T, covariance=1e-4 * np.eye(6), probability=0.0, residual=1.0,
        inlier_share=1.0, num_cells=9,
    )  # fmt: skip
    return Hypothesis(
        estimate=estimate, num_same=same, num_different=different,
        num_agreeing=30 if is_known else 0,
    )  # fmt: skip


def test_ambiguous_places_are_not_chosen():
    assert choose([hypothesis_at(0, 40, 1), hypothesis_at(9, 30, 9)]).T_world_left[0, 3] == 0
    assert (
        choose([hypothesis_at(0, 40, 1), hypothesis_at(9, 40, 1)]).reason
        == "several places look like it"
    )
    assert choose(
        [hypothesis_at(0, 40, 1), hypothesis_at(9, 39, 1, is_known=False)]
    ).reason.startswith("several")
    assert choose([hypothesis_at(9, 40, 0, is_known=False)]).reason == "too little is seen"
    assert choose([hypothesis_at(0, 40, 30)]).reason == "the map shows other things there"
    assert choose([hypothesis_at(0, 5, 0)]).reason == "too little is seen"
    assert choose([]).reason == "no place looks like it"


def test_features_decide_only_if_trusted():
    both = [hypothesis_at(0, 40, 1), hypothesis_at(9, 40, 1, is_known=False)]
    assert choose(both, trust=0.0).reason.startswith("several")
    assert choose(both, trust=8.0).T_world_left[0, 3] == 0
    assert (
        choose([hypothesis_at(9, 40, 0, is_known=False)], trust=8.0).reason == "too little is seen"
    )


def test_lookalike_places_reduce_the_trust_in_features():
    atlas = village().atlas
    trust = trust_in(atlas)
    assert trust > 0.0
    moved = atlas.T_world_left.copy()
    moved[1::2, 0, 3] += 50.0
    assert trust_in(replace(atlas, T_world_left=moved)) < 0.5 * trust
    assert trust_in(Atlas(places=[], numbers=[], T_world_left=np.zeros((0, 4, 4)))) == 0.0


def test_atlas_round_trips_and_a_damaged_file_is_rejected(tmp_path):
    atlas, path = village().atlas, tmp_path / "places.npz"
    atlas.save(path)
    again = Atlas.load(path)
    assert again.numbers == atlas.numbers
    assert np.array_equal(again.T_world_left, atlas.T_world_left)
    for one, other in zip(again.places, atlas.places, strict=True):
        assert one.rig == other.rig
        assert np.array_equal(one.descriptors, other.descriptors)
        assert np.allclose(one.sightings.points_px, other.sightings.points_px, atol=1e-4)
    first = path.read_bytes()
    atlas.save(path)
    assert path.read_bytes() == first
    path.write_bytes(first[: len(first) // 2])
    with pytest.raises(InputError, match=r"places\.npz"):
        Atlas.load(path)
    np.savez(path, version=np.array(1))
    with pytest.raises(InputError, match="not the places of a run"):
        Atlas.load(path)


def test_empty_atlas_round_trips(tmp_path):
    Atlas(places=[], numbers=[], T_world_left=np.zeros((0, 4, 4))).save(tmp_path / "places.npz")
    assert len(Atlas.load(tmp_path / "places.npz")) == 0


def test_recalled_pose_is_no_more_certain_than_that_of_its_place(known):
    unsure = replace(known, own=np.diag(np.repeat([0.01, 0.05], 3) ** 2))
    (one, *_) = [found for pair in village().others[1::2] if (found := unsure.recall(pair))]
    sigma = np.sqrt(np.diag(one.covariance))
    assert (sigma > np.repeat([0.01, 0.05], 3)).all()
