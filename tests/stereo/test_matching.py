"""Every matcher finds a plane with the correct sign, and handles unusual search ranges."""

import pickle

import numpy as np
import pytest

from recon.errors import InputError
from recon.records import Matches
from recon.settings import FeatureSettings, MatchingSettings
from recon.stereo.features import detect
from recon.stereo.matching import matching, phase
from recon.stereo.subpixel import refine
from scenes import step_pair, textured_pair, truth_at

SEARCH = {"min_disparity": 0, "max_disparity": 16}
EVERY_WAY = [
    {"matcher": "phase"},
    {"matcher": "phase", "cross_check": "row"},
    {"matcher": "phase", "support_sampling": "quarter"},
    {"matcher": "vonmises"},
    {"matcher": "sgbm"},
]


def solve(left, right, features=None, **values):
    settings = MatchingSettings(**(SEARCH | values))
    wanted = features or FeatureSettings()
    pair = detect(left, wanted), detect(right, wanted)
    return refine(matching.match(*pair, settings), *pair)


def share_right(matches, truth, within=1.0):
    return np.mean(np.abs(matches.disparity_px - truth_at(truth, matches)) <= within)


def test_table_names_every_matcher_of_the_settings():
    assert set(matching.MATCHERS.names()) >= {"phase", "vonmises", "sgbm"}


@pytest.mark.parametrize("way", EVERY_WAY, ids=lambda way: "-".join(way.values()))
def test_every_matcher_matches_a_plane(plane, way):
    left, right, truth = plane
    matches = solve(left, right, **way)
    assert len(matches) > 500
    assert share_right(matches, truth) > 0.97
    assert share_right(matches, -truth) < 0.05
    assert (np.diff(matches.score) <= 0).all()
    assert len(np.unique(matches.points_px, axis=0)) == len(matches)
    assert ((matches.sigma_px > 0) & (matches.sigma_px < 1)).all()
    assert (matches.index_left >= 0).all()
    assert (matches.index_right >= -1).all()
    again = pickle.loads(pickle.dumps(matches))
    np.testing.assert_array_equal(again.disparity_px, matches.disparity_px)


@pytest.mark.parametrize("way", EVERY_WAY, ids=lambda way: "-".join(way.values()))
def test_unrelated_images_give_low_confidence(plane, way):
    if way["matcher"] == "sgbm":
        pytest.skip("StereoSGBM has no confidence")
    noise = np.random.default_rng(1).integers(0, 256, plane[0].shape).astype(np.uint8)
    nonsense = solve(plane[0], noise, **way)
    right = solve(*plane[:2], **way)
    assert len(nonsense) < 0.9 * len(right)
    assert np.sum(nonsense.score > np.quantile(right.score, 0.1)) < 0.02 * len(right)


def test_converging_cameras_give_negative_disparities():
    left, right, truth = textured_pair(middle=-6.0)
    matches = solve(left, right, min_disparity=-12, max_disparity=3)
    assert share_right(matches, truth) > 0.98
    assert matches.disparity_px.max() < 0


def test_both_ends_of_the_range_are_searched():
    left, right, _ = textured_pair(slope=(0.0, 0.0), middle=7.0, noise=0.0)
    for low, high in [(7, 7), (7, 20), (0, 7)]:
        matches = solve(left, right, min_disparity=low, max_disparity=high)
        assert np.median(matches.disparity_px) == pytest.approx(7.0, abs=0.05)


@pytest.mark.parametrize("matcher", ["phase", "sgbm"])
@pytest.mark.parametrize("search", [(-1000, 1000), (0, 500), (-500, 20)])
def test_range_wider_than_the_image_is_clipped(plane, search, matcher):
    low, high = search
    matches = solve(*plane[:2], min_disparity=low, max_disparity=high, matcher=matcher)
    assert len(matches) > 500
    assert share_right(matches, plane[2]) > 0.95


@pytest.mark.parametrize("matcher", ["phase", "sgbm"])
@pytest.mark.parametrize("search", [(500, 600), (-900, -400)])
def test_range_outside_the_image_is_rejected(plane, search, matcher):
    low, high = search
    with pytest.raises(InputError, match="all lie outside the image, whose width is 160"):
        solve(*plane[:2], min_disparity=low, max_disparity=high, matcher=matcher)


def test_max_row_offset_px_tolerates_row_offsets():
    left, right, truth = textured_pair(row_shift=1, slope=(0.02, 0.0))
    strict, lenient = (solve(left, right, max_row_offset_px=rows) for rows in (0, 1))
    assert share_right(lenient, truth) > 0.98
    assert np.median(lenient.score) > np.median(strict.score) + 0.05


def test_keep_takes_the_most_confident_matches(plane):
    everything, few = solve(*plane[:2]), solve(*plane[:2], keep=50)
    assert len(few) == 50
    np.testing.assert_array_equal(few.points_px, everything.points_px[:50])
    np.testing.assert_array_equal(few.disparity_px, everything.disparity_px[:50])


def test_quota_per_block_spreads_the_matches(plane):
    matches = solve(*plane[:2], per_block=5)
    u, v = matches.points_px.astype(int).T // matching.BLOCK_PX
    _, counts = np.unique(v * 100 + u, return_counts=True)
    assert counts.max() == 5
    assert (np.diff(matches.score) <= 0).all()


def test_same_images_give_the_same_bytes(plane):
    first, second = solve(*plane[:2]), solve(*plane[:2])
    for name in ("points_px", "disparity_px", "sigma_px", "score"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


@pytest.mark.parametrize("matcher", ["phase", "sgbm", "vonmises"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (6, 6), (40, 40)])
def test_tiny_or_empty_images_give_no_matches(matcher, shape):
    image = np.full(shape, 50, np.uint8)
    assert len(solve(image, image, max_disparity=0, matcher=matcher)) == 0


def test_constant_image_gives_no_matches(plane):
    assert len(solve(plane[0], np.full_like(plane[0], 9))) == 0


def test_images_of_different_sizes_are_rejected(plane_features):
    other = detect(np.zeros((20, 20), np.uint8), FeatureSettings())
    with pytest.raises(InputError, match=r"left image has shape \(120, 160\), right \(20, 20\)"):
        matching.match(plane_features[0], other, MatchingSettings())


@pytest.mark.parametrize("widths", [(2.0,), (2.0, 4.0, 8.0, 16.0)])
def test_features_of_different_filters_are_rejected(plane, plane_features, widths):
    other = detect(plane[1], FeatureSettings(widths_px=widths))
    for step in (matching.match, lambda left, right, _: refine(Matches.none(), left, right)):
        for pair in ((plane_features[0], other), (other, plane_features[0])):
            with pytest.raises(InputError, match=r"px wide, .* but the same are needed"):
                step(*pair, MatchingSettings())


@pytest.mark.parametrize("width", [150, 157, 160])
def test_padding_of_rows_has_no_effect(width):
    left, right, _ = textured_pair(shape=(60, width), middle=-3.0)
    pair = [detect(image, FeatureSettings()) for image in (left, right)]
    settings = MatchingSettings(min_disparity=-9, max_disparity=4)
    clean = refine(matching.match(*pair, settings), *pair)
    for features in pair:
        features.planes[..., width:] = 1e4
    filled = refine(matching.match(*pair, settings), *pair)
    for name in ("points_px", "disparity_px", "sigma_px", "score"):
        np.testing.assert_array_equal(getattr(filled, name), getattr(clean, name))


def test_unknown_matcher_is_rejected_with_the_known_ones():
    with pytest.raises(InputError, match="matcher is 'sift', but one of phase, sgbm, vonmises"):
        matching.MATCHERS.load("sift")


def test_points_on_an_occluding_edge_move_to_the_side_of_their_disparity(monkeypatch):
    from recon.stereo.matching import phase

    left, right, truth = step_pair()
    moved = solve(left, right)
    monkeypatch.setattr(phase, "_DEAD_ZONE", np.inf)
    stayed = solve(left, right)
    monkeypatch.setattr(phase, "_DEAD_ZONE", 0.04)
    beside = np.abs(np.subtract.outer([30, 90], np.arange(120))).min(axis=0) <= 2
    near_edge = lambda m: beside[m.points_px[:, 1].astype(int)]  # noqa: E731
    wrong = [
        np.sum(np.abs(m.disparity_px - truth_at(truth, m))[near_edge(m)] > 1)
        for m in (moved, stayed)
    ]
    assert wrong[0] < 0.8 * wrong[1]


@pytest.mark.parametrize("scene", [textured_pair, step_pair])
def test_check_by_every_second_row_is_as_right_as_by_all(scene, monkeypatch):
    left, right, truth = scene()
    sparse = solve(left, right)
    monkeypatch.setattr(phase, "_EVERY_IN_CHECK", 1)
    full = solve(left, right)
    assert 0.97 * len(full) < len(sparse) < 1.01 * len(full)
    assert share_right(sparse, truth) > share_right(full, truth) - 0.002
    unchecked = solve(left, right, cross_check="row")
    assert share_right(sparse, truth) > share_right(unchecked, truth)
