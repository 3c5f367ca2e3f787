"""Planes over superpixels: exact on a plane, cut at edges, nothing where nothing supports it."""

import numpy as np
import pytest
from test_triangulation import matches_of

from recon.errors import InputError
from recon.records import Matches
from recon.settings import DenseSettings, FeatureSettings, MatchingSettings
from recon.stereo.dense.dense import densify, is_spike
from recon.stereo.dense.planes import disparity_of, fit_planes
from recon.stereo.dense.superpixels import cut
from recon.stereo.evaluation import seen_by_both
from recon.stereo.features import detect
from recon.stereo.matching import matching
from recon.stereo.subpixel import refine
from scenes import step_pair, textured_pair

SHAPE = (60, 80)


def matched(left, right):
    """Tuned matches, and the features of both images."""
    features = detect(left, FeatureSettings()), detect(right, FeatureSettings())
    found = matching.match(*features, MatchingSettings(max_disparity=20))
    return refine(found, *features), *features


def spread(left, right, is_kept=None, **settings):
    """Dense disparity, from all matches or some."""
    matches, *features = matched(left, right)
    if is_kept is not None:
        matches = matches.select(is_kept(*matches.points_px.T))
    return densify(matches, *features, left, DenseSettings(**settings))


@pytest.fixture(scope="module")
def step():
    return step_pair()


def grid_matches(disparity, spacing=3, noise=0.0, seed=0):
    v, u = np.mgrid[1 : SHAPE[0] : spacing, 1 : SHAPE[1] : spacing]
    points = np.column_stack([u.ravel(), v.ravel()])
    values = disparity[points[:, 1], points[:, 0]]
    return matches_of(points, values + np.random.default_rng(seed).normal(0, noise, len(points)))


def slanted():
    v, u = np.indices(SHAPE)
    return 5 + 0.05 * u + 0.02 * v


@pytest.mark.parametrize("channels", [1, 3])
def test_planes_are_those_of_the_matches(channels):
    image = np.full((*SHAPE, channels), 100, np.uint8).squeeze()
    patches = cut(image, 9.0)
    planes = fit_planes(grid_matches(slanted(), noise=0.05), patches, DenseSettings())
    found = disparity_of(planes, patches.label)
    assert np.isfinite(found).mean() > 0.95
    assert np.nanmedian(np.abs(found - slanted())) < 0.04
    assert np.nanmedian(np.abs(found - slanted() - 0.2)) > 0.1


def test_a_patch_with_too_few_matches_has_no_plane():
    patches = cut(np.full(SHAPE, 100, np.uint8), 9.0)
    everywhere = grid_matches(slanted())
    left_half = everywhere.select(everywhere.points_px[:, 0] < 30)
    found = disparity_of(fit_planes(left_half, patches, DenseSettings()), patches.label)
    assert np.isfinite(found[:, :20]).mean() > 0.9
    assert np.isnan(found[:, 50:]).all()


def test_patches_follow_edges_and_know_their_neighbours():
    image = np.full((40, 60), 40, np.uint8)
    image[:, 30:] = 200
    patches = cut(image, 10.0)
    assert set(patches.label[:, 29]).isdisjoint(patches.label[:, 30])
    assert patches.sizes.sum() == image.size
    touching = {(a, b) for a, row in enumerate(patches.neighbours) for b in row[row >= 0]}
    beside = set(zip(patches.label[:, 29].tolist(), patches.label[:, 30].tolist(), strict=True))
    assert beside <= touching
    assert {(b, a) for a, b in touching} == touching
    assert all(a != b for a, b in touching)


def test_a_slanted_plane_is_filled(plane):
    left, right, truth = plane
    found = spread(left, right)
    assert np.isfinite(found[:, 12:]).mean() > 0.9
    assert np.nanmedian(np.abs(found - truth)) < 0.06
    assert np.nanmedian(np.abs(found + truth)) > 1


def test_planes_reach_where_no_match_is_but_the_images_agree(plane):
    left, right, truth = plane
    found = spread(left, right, lambda u, v: (u < 70) | (u > 95) | (v < 50) | (v > 75))
    hole = (slice(53, 73), slice(73, 93))
    assert np.isfinite(found[hole]).mean() > 0.9
    assert np.nanmax(np.abs(found[hole] - truth[hole])) < 0.5


def test_disparity_jumps_where_the_image_does(step):
    left, right, truth = step
    found = spread(left, right)
    both = seen_by_both(truth) & np.isfinite(found)
    assert both.mean() > 0.8
    wrong = np.abs(found - truth)[both] > 1
    assert wrong.mean() < 0.04
    inside = found[40:80, 90:130]
    assert np.nanmedian(inside) == pytest.approx(12, abs=0.1)


def test_what_the_right_eye_cannot_see_is_unknown(step):
    left, right, truth = step
    hidden = np.isfinite(truth) & ~seen_by_both(truth)
    hidden[:, :16] = False  # beyond the border, not behind something
    found = spread(left, right)
    assert hidden.sum() > 300
    assert np.isnan(found[hidden]).mean() > 0.7


def test_where_the_images_disagree_nothing_is_known(plane):
    left, right, _ = plane
    strange = right.copy()
    noise = np.random.default_rng(2).integers(0, 256, right.shape)
    strange[:, 75:] = noise[:, 75:]
    found = spread(left, strange)
    assert np.isfinite(found[:, 20:70]).mean() > 0.8
    assert np.isfinite(found[:, 95:]).mean() < 0.1


def test_full_similarity_is_more_than_noisy_images_have(plane):
    assert np.isnan(spread(*plane[:2], min_similarity=1.0)).all()


def test_spikes_are_found_and_left_out():
    truth = slanted()
    truth[31, 31] += 20
    matches = grid_matches(truth)
    spikes = matches.points_px[is_spike(matches, DenseSettings())]
    assert spikes.tolist() == [[31, 31]]


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (6, 6)])
def test_tiny_images_and_no_matches_give_nothing(shape):
    image = np.zeros(shape, np.uint8)
    features = detect(image, FeatureSettings())
    found = densify(Matches.none(), features, features, image, DenseSettings())
    assert found.shape == shape
    assert np.isnan(found).all()


def test_matches_outside_the_image_are_refused():
    image = np.zeros((10, 10), np.uint8)
    features = detect(image, FeatureSettings())
    with pytest.raises(InputError, match="outside the image of 10 x 10 pixels"):
        densify(grid_matches(slanted()), features, features, image, DenseSettings())


def test_features_of_another_image_are_refused(plane_features):
    with pytest.raises(InputError, match=r"image has shape \(20, 20\)"):
        densify(Matches.none(), *plane_features, np.zeros((20, 20), np.uint8), DenseSettings())


def test_the_same_images_give_the_same_bytes():
    left, right, _ = textured_pair(shape=(50, 70))
    assert spread(left, right).tobytes() == spread(left, right).tobytes()
