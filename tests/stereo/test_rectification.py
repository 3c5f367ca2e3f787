"""The residual of a rig is estimated from row differences, unless noise hides it."""

import numpy as np
import pytest

from recon.camera import TYPICAL_RESIDUAL_PX
from recon.settings import FeatureSettings, MatchingSettings
from recon.stereo.features import detect
from recon.stereo.matching import matching
from recon.stereo.rectification import residual_of_rows
from recon.stereo.subpixel import refine
from scenes import textured_pair


def matched(row_shift=0.0, noise=1.0, widths=(1.5, 3.0, 6.0)):
    left, right, _ = textured_pair(row_shift=row_shift, noise=noise)
    features = [detect(image, FeatureSettings(widths_px=widths)) for image in (left, right)]
    return features, matching.match(*features, MatchingSettings(max_disparity=16))


def residual(features, matches):
    u, v = matches.points_px.astype(np.int64).T
    w = u - np.rint(matches.disparity_px).astype(np.int64)
    height, width = features[0].grey.shape
    inside = (np.minimum(u, w) > 0) & (np.maximum(u, w) < width - 1) & (v > 0) & (v < height - 1)
    scales = np.flatnonzero(np.array(features[0].widths_px) >= 2)
    pixels = tuple(column[inside] for column in (u, v, w))
    return residual_of_rows(*(one.planes for one in features), scales, pixels)


@pytest.mark.parametrize("widths", [(1.5, 3.0, 6.0), (2.0,)])
def test_row_differences_give_the_residual_of_a_typical_rig(widths):
    exact, off, far_off = (
        residual(*matched(row_shift, widths=widths)) for row_shift in (0.0, -0.1, 0.4)
    )
    assert 0 <= exact < 0.3 * TYPICAL_RESIDUAL_PX
    assert 0.85 * TYPICAL_RESIDUAL_PX < off < far_off < TYPICAL_RESIDUAL_PX


def test_residual_hidden_by_noise_is_not_taken_for_zero():
    residuals = [residual(*matched(noise=noise)) for noise in (1.0, 10.0)]
    assert residuals[1] > 1.5 * residuals[0]


def test_few_matches_give_the_residual_of_a_typical_rig():
    features, matches = matched()
    for num in (0, 5):
        assert residual(features, matches.select(slice(0, num))) == TYPICAL_RESIDUAL_PX


def test_refinement_estimates_the_residual_if_the_rig_does_not_state_it():
    features, matches = matched()
    asked, exact, typical = (
        np.median(refine(matches, *features, one).sigma_px) for one in (None, 0.0, 0.13)
    )
    assert exact < asked < 0.5 * (exact + typical)
    assert np.median(refine(matches, *features).sigma_px) == typical
