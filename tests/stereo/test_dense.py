"""Dense matching: exact on planes, sharp at edges, honest sigma, bounded memory."""

import numpy as np
import pytest

import recon
from recon.errors import InputError
from recon.records import DisparityMap
from recon.settings import DenseSettings, MatchingSettings, Settings
from recon.stereo.dense import dense as dense_stage
from recon.stereo.dense import uncertainty
from recon.stereo.dense.cost import Search, cost_volume
from recon.stereo.dense.dense import match_every_pixel
from recon.stereo.dense.peers import PEERS
from recon.stereo.evaluation import seen_by_both
from scenes import step_pair, textured_pair

QUALITIES = ["best", "fast"]


def error_of(found, truth):
    return np.abs(found.disparity_px - truth)


def matched(left, right, max_disparity=20, min_disparity=0, **dense):
    search = MatchingSettings(min_disparity=min_disparity, max_disparity=max_disparity)
    settings = Settings(matching=search, dense=DenseSettings(**dense))
    return match_every_pixel(left, right, settings)


@pytest.fixture(scope="module")
def step():
    return step_pair()


@pytest.mark.parametrize(("quality", "median_px"), [("best", 0.06), ("fast", 0.15)])
def test_slanted_plane_is_matched_everywhere(plane, quality, median_px):
    left, right, truth = plane
    found = recon.match_dense(left, right, quality=quality)
    assert isinstance(found, DisparityMap)
    assert found.disparity_px.dtype == found.sigma_px.dtype == np.float32
    inside = found.disparity_px[:, 14:]
    assert np.isfinite(inside).mean() > 0.97
    error = error_of(found, truth)
    assert np.nanmedian(error) < median_px
    assert np.nanquantile(error, 0.95) < 4 * median_px
    # Negative control: disparities off by one pixel exceed the bounds.
    assert np.nanmedian(np.abs(found.disparity_px + 1 - truth)) > 0.9


def test_negative_disparities_are_searched(plane):
    left, right, truth = plane
    found = matched(right, left, min_disparity=-20, max_disparity=0)
    # Pixels of the right image shift the other way.
    assert np.nanmedian(found.disparity_px) == pytest.approx(-np.median(truth), abs=0.3)
    outside = matched(right, left, min_disparity=0, max_disparity=20)
    assert outside.coverage < found.coverage / 2


@pytest.mark.parametrize("quality", QUALITIES)
def test_disparity_jumps_at_image_edges(step, quality):
    left, right, truth = step
    found = recon.match_dense(left, right, quality=quality)
    both = seen_by_both(truth)
    assert (error_of(found, truth)[both] <= 1).mean() > 0.95
    assert np.nanmedian(found.disparity_px[40:80, 90:130]) == pytest.approx(12, abs=0.1)


def test_occluded_pixels_get_background_disparity_and_large_sigma(step):
    left, right, truth = step
    hidden = ~seen_by_both(truth)
    hidden[:, :16] = False  # beyond the border, not behind something
    found = matched(left, right)
    known = hidden & found.valid_mask
    assert known.sum() > 100
    assert (error_of(found, truth)[known] <= 1).mean() > 0.7
    visible = seen_by_both(truth) & found.valid_mask
    assert np.median(found.sigma_px[known]) > 3 * np.median(found.sigma_px[visible])
    unfilled = matched(left, right, fill_px=0)
    assert np.isnan(unfilled.disparity_px[hidden]).mean() > 0.6


def test_sigma_matches_the_error():
    within_one, within_two = [], []
    for seed, noise in ((1, 1.0), (2, 3.0), (3, 6.0)):
        left, right, truth = textured_pair(noise=noise, seed=seed)
        found = matched(left, right)
        error = error_of(found, truth)[:, 14:]
        within_one.append(np.nanmean(error <= found.sigma_px[:, 14:]))
        within_two.append(np.nanmean(error <= 2 * found.sigma_px[:, 14:]))
    assert min(within_one) > 0.5
    assert min(within_two) > 0.85


def test_sigma_grows_with_noise():
    medians = []
    for noise in (0.5, 8.0):
        left, right, _ = textured_pair(noise=noise, seed=4)
        medians.append(np.nanmedian(matched(left, right).sigma_px))
    assert medians[1] > 1.3 * medians[0]


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("noise", [1.0, 4.0])
def test_disparity_is_uncertain_where_the_image_may_be_pure_noise(noise, quality):
    left, right, _ = textured_pair(noise=noise)
    rng = np.random.default_rng(3)
    for image in (left, right):
        image[60:] = np.rint(rng.normal(128, noise, image[60:].shape))
    found = recon.match_dense(left, right, quality=quality)
    flat, textured = found.sigma_px[68:], found.sigma_px[:52]
    assert (flat[np.isfinite(flat)] >= 1).mean() > 0.9
    assert np.nanmedian(textured) < 0.3


def test_few_disparities_are_known_where_the_images_disagree(plane):
    left, right, _ = plane
    strange = right.copy()
    noise = np.random.default_rng(2).integers(0, 256, right.shape)
    strange[:, 75:] = noise[:, 75:]
    found = matched(left, strange)
    assert np.isfinite(found.disparity_px[:, 20:70]).mean() > 0.9
    assert np.isfinite(found.disparity_px[:, 100:]).mean() < 0.4


def test_strips_give_the_result_of_the_whole_image(plane, monkeypatch):
    left, right, truth = plane
    whole = matched(left, right)
    bytes_per_row = 4 * left.shape[1] * Search(0, 21).depth
    monkeypatch.setattr(dense_stage, "_STRIP_BYTES", 96 * bytes_per_row)
    strips = matched(left, right)
    assert strips.coverage == pytest.approx(whole.coverage, abs=0.01)
    differs = np.abs(strips.disparity_px - whole.disparity_px) > 0.25
    assert differs.mean() < 0.01
    assert np.nanmedian(error_of(strips, truth)) < 0.06


def test_grey_and_coloured_images_agree(plane):
    left, right, _ = plane
    grey = matched(left, right)
    coloured = matched(*(np.repeat(x[..., None], 3, axis=2) for x in (left, right)))
    np.testing.assert_allclose(grey.disparity_px, coloured.disparity_px, atol=0.05)


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (6, 6), (3, 17)])
def test_small_images_are_matched(shape, quality):
    image = np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8)
    found = recon.match_dense(image, image, max_disparity=5, quality=quality)
    assert found.disparity_px.shape == shape
    assert np.isfinite(found.sigma_px[found.valid_mask]).all()


@pytest.mark.parametrize("quality", QUALITIES)
def test_flat_images_are_uncertain(quality):
    flat = np.full((40, 60), 90, np.uint8)
    found = recon.match_dense(flat, flat, quality=quality)
    sure = found.valid_mask & (found.sigma_px < 0.3)
    assert sure.mean() < 0.05


def test_images_of_different_sizes_and_empty_searches_are_rejected():
    image = np.zeros((10, 12), np.uint8)
    with pytest.raises(InputError, match="left image has shape"):
        recon.match_dense(image, image[:, :10])
    with pytest.raises(InputError, match="all lie outside the image, whose width is 12"):
        recon.match_dense(image, image, min_disparity=12, max_disparity=20)
    with pytest.raises(InputError, match="quality is 'better'"):
        recon.match_dense(image, image, quality="better")


@pytest.mark.parametrize("quality", QUALITIES)
def test_same_images_give_the_same_bytes(quality):
    left, right, _ = textured_pair(shape=(50, 70))
    first, second = (recon.match_dense(left, right, quality=quality) for _ in range(2))
    assert first.disparity_px.tobytes() == second.disparity_px.tobytes()
    assert first.sigma_px.tobytes() == second.sigma_px.tobytes()


def test_true_disparity_has_the_lowest_cost():
    left, right, _ = textured_pair(slope=(0.0, 0.0), middle=7.0, noise=0.5)
    cost = cost_volume(left, right, Search(2, 10))
    assert cost.shape == (*left.shape, 16)
    cheapest = cost[10:-10, 20:-10].argmin(axis=2) + 2
    assert (cheapest == 7).mean() > 0.9
    assert (cost[..., 10:] > cost[..., :10].max()).all()


@pytest.mark.parametrize("name", PEERS)
def test_peers_match_a_plane(plane, name):
    left, right, truth = plane
    found = PEERS[name](left, right, Search(0, 21))
    assert np.isfinite(found[:, 20:]).mean() > 0.7
    assert np.nanmedian(np.abs(found - truth)) < 0.2


def test_sigma_decreases_with_distinctness_and_grows_with_spread():
    shape = (20, 20)

    def sigma(steepness, lead, spread):
        parts = (np.zeros(shape), np.full(shape, steepness), np.full(shape, lead), np.zeros(shape))
        choice = dense_stage.Choice(*(part.astype(np.float32) for part in parts))
        grey = np.tile(np.arange(20, dtype=np.uint8) * 10, (20, 1))
        field = np.full(shape, spread, np.float32)
        return uncertainty.of_choice(choice, field, grey)[10, 10].item()

    assert sigma(5, 5, 0.1) < sigma(0.5, 5, 0.1)
    assert sigma(5, 5, 0.1) < sigma(5, 0.5, 0.1)
    assert sigma(5, 5, 0.1) < sigma(5, 5, 0.5)


@pytest.mark.parametrize("part", [0.2, 0.3, 0.4])
def test_fractional_disparities_are_not_biased_to_whole_pixels(part):
    left, right, _ = textured_pair(slope=(0.0, 0.0), middle=7 + part, noise=1.0, seed=3)
    inside = matched(left, right).disparity_px[10:-10, 20:-10]
    assert np.nanmedian(inside) == pytest.approx(7 + part, abs=0.06)
