"""Rows that differ are noticed in the matches themselves, and noise is not taken for it."""

import dataclasses

import numpy as np
import pytest

from recon.settings import FeatureSettings, MatchingSettings
from recon.stereo.features import detect
from recon.stereo.matching import matching
from recon.stereo.rectification import row_residual_sq
from recon.stereo.subpixel import refine
from scenes import textured_pair


def matched(row_shift=0.0, noise=1.0, widths=(1.5, 3.0, 6.0)):
    left, right, _ = textured_pair(row_shift=row_shift, noise=noise)
    features = [detect(image, FeatureSettings(widths_px=widths)) for image in (left, right)]
    return features, matching.match(*features, MatchingSettings(max_disparity=16))


def residual_sq(features, matches, num=None):
    u, v = matches.points_px[:num].astype(np.int64).T
    pixels = u, v, u - np.rint(matches.disparity_px[:num]).astype(np.int64)
    widths = np.array(features[0].widths_px)
    last = features[0].grey.shape[1] - 1
    planes = (one.planes for one in features)
    return row_residual_sq(*planes, np.flatnonzero(widths >= 2), pixels, last)


@pytest.mark.parametrize("widths", [(1.5, 3.0, 6.0), (2.0,)])
@pytest.mark.parametrize("row_shift", [-0.3, 0.3, 0.5])
def test_an_offset_of_the_rows_comes_out(row_shift, widths):
    found = residual_sq(*matched(row_shift, widths=widths))
    assert found == pytest.approx(row_shift**2, rel=0.35)


def test_exact_rows_have_none_and_noise_is_not_taken_for_it():
    assert residual_sq(*matched()) < 0.002
    assert residual_sq(*matched(noise=6.0)) < 0.02


def test_of_few_matches_it_is_unknown():
    features, matches = matched()
    assert residual_sq(features, matches, num=10) == np.inf
    assert residual_sq(features, matches.select(slice(0, 0))) == np.inf


def test_rows_that_differ_make_sigma_larger():
    medians = []
    for row_shift in (0.0, 0.4):
        features, matches = matched(row_shift)
        medians.append(np.median(refine(matches, *features).sigma_px))
    assert medians[1] > 1.2 * medians[0]


def test_pairs_that_may_be_wrong_have_a_larger_sigma():
    features, matches = matched()
    medians = []
    for probability in (0.999, 0.6):
        one = dataclasses.replace(matches, probability=np.full(len(matches), probability))
        medians.append(np.median(refine(one, *features).sigma_px))
    assert medians[1] > 1.5 * medians[0]
