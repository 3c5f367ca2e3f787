"""Sub-pixel refinement has the right sign, helps, breaks no match, and has a consistent sigma."""

import dataclasses

import numpy as np
import pytest

from recon.errors import InputError
from recon.settings import FeatureSettings, MatchingSettings
from recon.stereo.features import detect
from recon.stereo.matching import matching
from recon.stereo.subpixel import refine
from scenes import textured_pair, truth_at


def coarse_and_fine(left, right, **features):
    settings = FeatureSettings(**features)
    pair = detect(left, settings), detect(right, settings)
    coarse = matching.match(*pair, MatchingSettings(max_disparity=16))
    return coarse, refine(coarse, *pair)


@pytest.mark.parametrize("fraction", [-0.4, -0.2, 0.0, 0.3, 0.5])
def test_fractions_of_a_pixel_are_recovered_with_their_sign(fraction):
    left, right, truth = textured_pair(slope=(0.0, 0.0), middle=8 + fraction, noise=0.5)
    _, fine = coarse_and_fine(left, right)
    error = fine.disparity_px - truth_at(truth, fine)
    assert abs(np.median(error)) < 0.03
    if fraction:
        # The other sign would double the fraction as an error.
        assert np.median(np.abs(error)) < 0.3 * abs(2 * fraction)


@pytest.mark.parametrize("widths", [(1.5, 3.0, 6.0), (2.0,), (2.0, 4.0)])
def test_refinement_beats_whole_pixels_and_breaks_no_match(plane, widths):
    coarse, fine = coarse_and_fine(*plane[:2], widths_px=widths)
    truth = truth_at(plane[2], coarse)
    before, after = (np.abs(m.disparity_px - truth) for m in (coarse, fine))
    assert 0.2 < np.median(before) < 0.3
    assert np.median(after) < 0.08
    assert np.sum(after > 1) <= np.sum(before > 1)


def test_sigma_of_an_exact_rig_matches_the_error(plane):
    pair = [detect(image, FeatureSettings()) for image in plane[:2]]
    coarse = matching.match(*pair, MatchingSettings(max_disparity=16))
    error = refine(coarse, *pair).disparity_px - truth_at(plane[2], coarse)
    good = np.abs(error) <= 1
    spreads = [
        np.std(error[good] / refine(coarse, *pair, residual_px).sigma_px[good])
        for residual_px in (0.0, 0.3)
    ]
    # This plane has no silhouettes, where errors are largest: sigma covers them as well.
    assert 0.35 < spreads[0] < 1.1
    assert spreads[1] < 0.2  # such a calibration error would be visible


def test_residual_of_the_rig_adds_to_the_variance(plane_features):
    coarse = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    exact, recorded = (refine(coarse, *plane_features, r) for r in (0.0, 0.2))
    np.testing.assert_allclose(recorded.sigma_px**2 - exact.sigma_px**2, 0.04, rtol=1e-4)
    assert (exact.disparity_px == recorded.disparity_px).all()


def test_doubtful_matches_have_a_larger_sigma(plane_features):
    coarse = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    medians = []
    for probability in (0.999, 0.9, np.nan):
        one = dataclasses.replace(coarse, probability=np.full(len(coarse), probability))
        medians.append(np.median(refine(one, *plane_features, 0.0).sigma_px))
    assert medians[1] > 2 * medians[0]
    assert medians[2] == pytest.approx(medians[0], rel=0.05)  # an unknown probability adds no doubt


def test_more_noise_gives_larger_error_and_sigma():
    def numbers(noise):
        left, right, truth = textured_pair(noise=noise)
        _, fine = coarse_and_fine(left, right)
        error = np.abs(fine.disparity_px - truth_at(truth, fine))
        return np.median(error), np.median(fine.sigma_px)

    quiet, loud = numbers(0.5), numbers(12.0)
    assert loud[0] > 1.2 * quiet[0]
    assert loud[1] > 1.1 * quiet[1]


def test_too_fine_filters_leave_whole_pixels(plane):
    coarse, fine = coarse_and_fine(*plane[:2], widths_px=(1.5,))
    np.testing.assert_array_equal(coarse.disparity_px, fine.disparity_px)
    assert fine.is_whole.all()
    assert (fine.sigma_px > 0.3).all()


def test_edge_along_the_row_counts_as_whole():
    """It has no disparity of its own, but takes that of what stands near."""
    v, u = np.mgrid[:64, :96].astype(float)
    along, across = (
        coarse_and_fine(step, np.roll(step, -4, axis=1))[1]
        for distance in (v - 32 - 0.06 * (u - 48), u - 48 - 0.06 * (v - 32))
        for step in [np.rint(130 + 70 * np.clip(distance, -1, 1)).astype(np.uint8)]
    )
    inner = (np.abs(along.points_px[:, 0] - 48) < 30) & (np.abs(along.points_px[:, 1] - 32) < 6)
    assert inner.any()
    assert along.is_whole[inner].mean() > 0.9
    beside = np.abs(across.points_px[:, 0] - 48) < 6
    assert beside.any()
    assert not across.is_whole[beside].any()


def test_refined_matches_are_left_unchanged(plane, plane_features):
    coarse = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    done = dataclasses.replace(coarse, sigma_px=np.full(len(coarse), 0.2))
    again = refine(done, *plane_features)
    np.testing.assert_array_equal(again.disparity_px, done.disparity_px)
    np.testing.assert_array_equal(again.sigma_px, done.sigma_px)


def test_sigma_is_unknown_before_refinement(plane_features):
    coarse = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    assert np.isnan(coarse.sigma_px).all()
    assert (coarse.disparity_px == np.rint(coarse.disparity_px)).all()


@pytest.mark.parametrize(
    "change",
    [{"points_px": np.array([1000.0, 5.0])}, {"points_px": np.array([5.0, -1.0])},
     {"disparity_px": np.array(500.0)}, {"disparity_px": np.array(-500.0)}],
    ids=["right of it", "above it", "partner left of it", "partner right of it"],
)  # fmt: skip
def test_matches_outside_the_image_are_rejected(plane_features, change):
    coarse = matching.match(*plane_features, MatchingSettings(max_disparity=16))
    ((name, value),) = change.items()
    numbers = getattr(coarse, name).copy()
    numbers[7] = value
    wrong = dataclasses.replace(coarse, **{name: numbers})
    with pytest.raises(InputError, match="matches lie outside the image of 160 x 120 pixels"):
        refine(wrong, *plane_features)
