"""Steps of dense matching against slow references: paths, planes, medians, holes, specks."""

import numpy as np
import pytest

from recon.stereo.dense.borders import at_image_edges
from recon.stereo.dense.cost import Search
from recon.stereo.dense.holes import filled_behind, without_specks
from recon.stereo.dense.paths import Penalties, aggregate
from recon.stereo.dense.peers import confirmed_three_ways, three_ways
from recon.stereo.dense.surfaces import median, smooth
from scenes import step_pair

NAN = np.float32(np.nan)


def reference_paths(cost, grey, penalties):
    """Hirschmueller's recursion, as published."""
    height, width, _ = cost.shape
    total = np.zeros(cost.shape, np.int64)
    for dv, du in [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]:
        path = np.zeros((height + 2, width + 2, cost.shape[2]), np.int64)
        order = np.argwhere(np.ones((height, width), bool))
        for v, u in order if (dv, du) > (0, -1) else order[::-1]:
            inside = 0 <= v - dv < height and 0 <= u - du < width
            there = grey[v - dv, u - du] if inside else grey[v, u]
            last = path[v - dv, u - du]
            up, down = np.append(last[1:], 10**6), np.append(10**6, last[:-1])
            sides = np.minimum(up, down) + penalties.small_step
            jump = last.min() + penalties.large_step[abs(int(grey[v, u]) - int(there))]
            best = np.minimum(np.minimum(last, sides), jump) - last.min()
            path[v, u] = cost[v, u] + best
        total += path[:height, :width]
    return total


@pytest.mark.parametrize("shape", [(9, 11, 32), (1, 7, 16), (6, 1, 16), (1, 1, 16)])
def test_paths_match_the_reference(shape):
    rng = np.random.default_rng(sum(shape))
    cost = rng.integers(0, 1000, shape).astype(np.int16)
    grey = rng.integers(0, 256, shape[:2]).astype(np.uint8)
    penalties = Penalties(200, np.linspace(900, 300, 256).astype(np.int16))
    np.testing.assert_array_equal(
        aggregate(cost, grey, penalties), reference_paths(cost, grey, penalties)
    )


def slanted(shape=(30, 40)):
    v, u = np.indices(shape, dtype=np.float32)
    return np.float32(5) + np.float32(0.05) * u + np.float32(0.02) * v


def test_smoothing_keeps_planes_and_reduces_noise():
    truth, grey = slanted(), np.full((30, 40), 90, np.uint8)
    exact = smooth(truth, grey)
    # Windows cut off by the border are slightly biased to be level.
    np.testing.assert_allclose(exact.disparity_px[3:-3, 3:-3], truth[3:-3, 3:-3], atol=1e-4)
    noisy = truth + np.random.default_rng(0).normal(0, 0.1, truth.shape).astype(np.float32)
    found = smooth(noisy, grey)
    assert np.std(found.disparity_px - truth) < 0.35 * np.std(noisy - truth)
    assert 0.05 < np.median(found.spread_px) < 0.12


def test_smoothing_stops_at_jumps_and_keeps_holes():
    disparity = np.full((20, 30), 4, np.float32)
    disparity[:, 15:] = 9
    disparity[5:8, 5:8] = NAN
    found = smooth(disparity, np.full((20, 30), 90, np.uint8))
    np.testing.assert_allclose(found.disparity_px, disparity, atol=1e-6)
    assert np.isnan(found.spread_px[6, 6])


def test_dissimilar_pixels_have_less_weight():
    disparity = np.full((15, 15), 4, np.float32)
    disparity[:, 8:] = 4.6
    grey = np.full((15, 15), 60, np.uint8)
    blind = smooth(disparity, grey).disparity_px[7, 6]
    grey[:, 8:] = 160
    seeing = smooth(disparity, grey).disparity_px[7, 6]
    assert abs(seeing - 4) < 0.3 * abs(blind - 4)


def test_median_ignores_unknown_values():
    disparity = np.random.default_rng(1).normal(10, 3, (9, 12)).astype(np.float32)
    disparity[3, 4] = disparity[0, 0] = NAN
    found = median(disparity)
    padded = np.pad(disparity, 1, constant_values=np.nan)
    for v, u in np.argwhere(np.isfinite(disparity)):
        assert found[v, u] == pytest.approx(np.nanmedian(padded[v : v + 3, u : u + 3]), abs=1e-5)
    assert np.isnan(found[3, 4])


def test_small_patches_are_removed_as_specks():
    disparity = np.full((30, 40), 6, np.float32)
    disparity[10:13, 10:13] = 20
    kept = without_specks(disparity, 9)
    assert np.isnan(kept[10:13, 10:13]).all()
    assert np.isfinite(kept).sum() == disparity.size - 9
    np.testing.assert_array_equal(without_specks(disparity, 8), disparity)
    nothing = np.full((4, 4), NAN)
    assert np.isnan(without_specks(nothing, 5)).all()


def test_holes_are_filled_with_the_background():
    disparity = np.full((20, 40), 4, np.float32)
    disparity[:, 20:] = 12
    disparity[:, 15:20] = NAN
    found = filled_behind(disparity, 8)
    np.testing.assert_array_equal(found[5:15, 15:20], np.full((10, 5), 4, np.float32))
    narrow = filled_behind(disparity, 2)
    assert np.isfinite(narrow[10, 15:17]).all()
    assert np.isnan(narrow[10, 17:20]).all()
    np.testing.assert_array_equal(filled_behind(disparity, 0), disparity)


def test_hole_without_agreeing_neighbours_stays():
    disparity = np.full((3, 9), NAN)
    disparity[1, 0] = 5
    assert np.isfinite(filled_behind(disparity, 8)).sum() == 1


def test_peers_drop_pixels_that_the_right_image_contradicts():
    left, right, truth = step_pair()
    # The wall beside the square is hidden from the right camera.
    hidden = np.zeros(truth.shape, bool)
    hidden[34:86, 73:79] = True
    search = Search(0, 16)
    alone, confirmed = three_ways(left, right, search), confirmed_three_ways(left, right, search)
    kept = np.isfinite(confirmed)
    np.testing.assert_array_equal(confirmed[kept], alone[kept])
    wrong = [np.abs(found - truth) > 1 for found in (alone, confirmed)]
    assert wrong[1].sum() <= 0.8 * wrong[0].sum()
    assert kept[~hidden].mean() > 0.9 * np.isfinite(alone[~hidden]).mean()


def test_borders_move_to_image_edges():
    image = np.full((30, 40, 3), (90, 60, 100), np.uint8)
    image[:, 20:] = (60, 75, 100)
    fattened = np.full((30, 40), 4, np.float32)
    fattened[:, 19:] = 12  # one column too far
    fattened[5, 30] = NAN
    found = at_image_edges(fattened, image)
    assert (found[:, :20] == 4).all()
    assert (np.delete(found[:, 20:], 10, axis=1) == 12).all()
    assert np.isnan(found[5, 30])
    # Negative controls: no edge in the image, or no border in the disparities.
    np.testing.assert_array_equal(at_image_edges(fattened, np.full_like(image, 90)), fattened)
    plane = slanted((30, 40))
    np.testing.assert_array_equal(at_image_edges(plane, image), plane)


@pytest.mark.parametrize("seed", range(3))
def test_medians_at_borders_match_the_definition(seed):
    rng = np.random.default_rng(seed)
    image = rng.integers(0, 60, (9, 11)).astype(np.uint8)
    disparity = rng.uniform(0, 9, (9, 11)).astype(np.float32)
    disparity[rng.random((9, 11)) < 0.2] = NAN
    found = at_image_edges(disparity, image)
    rows, columns = np.indices(image.shape)
    for v, u in np.argwhere(np.isfinite(disparity)):
        near = (abs(rows - v) <= 3) & (abs(columns - u) <= 3) & np.isfinite(disparity)
        unlike = np.abs(image[near].astype(int) - int(image[v, u]))
        apart_sq = (rows[near] - v) ** 2 + (columns[near] - u) ** 2
        weight = np.exp(-unlike / 8 - apart_sq / 32)
        below = weight[disparity[near] < found[v, u]].sum()
        above = weight[disparity[near] > found[v, u]].sum()
        assert max(below, above) <= weight.sum() / 2 + 1e-4
