"""Metrics of correct and wrong matches, counted by hand."""

import numpy as np
import pytest
from test_triangulation import matches_of

from recon.errors import InputError
from recon.records import Matches
from recon.stereo.evaluation import coverage, evaluate, evaluate_map, seen_by_both


def flat_truth(value=4.0, shape=(40, 60)):
    return np.full(shape, value)


def test_hand_counted_numbers():
    truth = flat_truth()
    truth[5, 50] = np.nan
    points = [[20, 5], [30, 5], [40, 5], [50, 5]]
    found = evaluate(matches_of(points, [4.1, 4.5, 6.0, 9.0]), truth)
    assert (found.num_judged, found.num_mismatches) == (3, 1)
    assert found.success_all == pytest.approx(200 / 3)
    assert found.bad_share == pytest.approx(1 / 3)
    assert found.rms_px == pytest.approx(np.sqrt((0.01 + 0.25 + 4.0) / 3))
    assert found.subpixel_median_px == pytest.approx(0.3)
    assert found.subpixel_rms_px == pytest.approx(np.sqrt(0.13))


def test_error_of_exactly_one_pixel_is_not_a_mismatch():
    assert evaluate(matches_of([[20, 5]], [5.0]), flat_truth()).num_mismatches == 0


@pytest.mark.parametrize(("step", "mismatches"), [(0.0, 1), (1.0, 0)])
def test_disparities_are_rounded_for_rounded_truth(step, mismatches):
    assert evaluate(matches_of([[20, 5]], [5.3]), flat_truth(), step).num_mismatches == mismatches


def test_points_covered_by_nearer_ones_are_occluded():
    truth = flat_truth(2.0)
    truth[:, 30:40] = 10.0
    seen = seen_by_both(truth)
    assert seen[:, 30:40].all()
    # The near strip covers the right pixels 20..29, which far left pixels 22..29 had.
    assert not seen[:, 22:30].any()
    assert seen[:, 2:22].all()
    assert not seen[:, :2].any()  # outside the right image
    found = evaluate(matches_of([[25, 5], [10, 5]], [9.0, 2.0]), truth)
    assert (found.success_all, found.success_nonocc) == (50.0, 100.0)


def test_truth_of_the_right_image_decides_occlusion():
    truth, right = flat_truth(2.0), flat_truth(2.0)
    right[:, 10] = 7.0
    seen = seen_by_both(truth, right)
    assert not seen[:, 12].any()
    assert seen[:, 13].all()
    matches = matches_of([[12, 5], [20, 5]], [9.0, 2.0])
    assert evaluate(matches, truth, 0.0, right).success_nonocc == 100.0
    assert evaluate(matches, truth).success_nonocc == 50.0
    with pytest.raises(InputError, match="truth_right_px has shape"):
        evaluate(matches, truth, 0.0, right[1:])


def test_no_matches_give_unknown_metrics():
    numbers = evaluate(Matches.none(), flat_truth()).as_metrics()
    assert numbers["num_mismatches"] == 0
    assert numbers["success_all"] is None
    assert numbers["subpixel_median_px"] is None


def test_truth_of_another_size_is_rejected():
    with pytest.raises(InputError, match=r"truth is 60 x 40 pixels, but a match lies at \(80, 5\)"):
        evaluate(matches_of([[80, 5]], [1.0]), flat_truth())


def test_coverage_counts_blocks():
    assert coverage(matches_of([[0, 0], [31, 31], [33, 0]], [1, 1, 1]), (64, 64)) == 0.5
    assert coverage(Matches.none(), (64, 64)) == 0.0


def test_disparity_map_is_evaluated_like_matches_at_its_pixels():
    rng = np.random.default_rng(4)
    truth = np.full((8, 9), 3.0)
    truth[0] = np.nan
    found = truth + rng.normal(0, 1, truth.shape)
    found[2] = np.nan
    v, u = np.nonzero(np.isfinite(found))
    matches = matches_of(np.column_stack([u, v]), found[v, u])
    assert evaluate_map(found, truth) == evaluate(matches, truth)
    assert evaluate_map(found, truth).num_judged == 6 * 9
