"""Cameras of different gain and offset match like equal ones; equal ones are left unchanged."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.mapping.pair import match_pair
from recon.stereo.dense.dense import match_dense
from recon.stereo.exposure import gain_between, with_gain_of
from scenes import step_pair, textured_pair, truth_at


def exposed_with(image, gain, offset=0.0):
    return np.clip(np.rint(gain * image + offset), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def pair():
    left, right, truth = textured_pair(noise=1.0)
    # Dark enough that no gain or offset of these tests clips it.
    return exposed_with(left, 0.6, 20), exposed_with(right, 0.6, 20), truth


@settings(max_examples=20)
@given(gain=st.floats(1.1, 1.3), offset=st.floats(-20, 10))
def test_gain_is_measured_whatever_the_offset(pair, gain, offset):
    left, right, _ = pair
    assert gain_between(left, exposed_with(right, gain, offset)) == pytest.approx(gain, rel=0.02)
    assert gain_between(exposed_with(left, gain, offset), right) == pytest.approx(
        1 / gain, rel=0.02
    )


def test_equal_cameras_are_left_unchanged(pair):
    left, right, _ = pair
    assert gain_between(left, right) == 1.0
    assert with_gain_of(left, right) is right
    near_left, near_right, _ = step_pair()
    assert gain_between(near_left, near_right) == 1.0


def test_content_seen_by_one_camera_is_not_taken_for_gain(pair):
    left, right, _ = pair
    rng = np.random.default_rng(0)
    seen = left.copy()
    seen[:80, :40] = rng.integers(0, 256, (80, 40))
    assert gain_between(seen, right) == 1.0
    assert gain_between(np.full_like(left, 7), right) == 1.0
    assert gain_between(left[:, :3], right[:, :3]) == 1.0


@pytest.mark.parametrize("quality", ["best", "fast"])
def test_cameras_of_different_exposure_match_like_equal_ones(pair, quality):
    left, right, truth = pair
    found = [
        match_pair(left, image, max_disparity=16, quality=quality)
        for image in (right, exposed_with(right, 1.15, -8))
    ]
    right_shares = [
        np.mean(np.abs(matches.disparity_px - truth_at(truth, matches)) < 0.5) for matches in found
    ]
    assert right_shares[1] == pytest.approx(right_shares[0], abs=0.005)
    assert len(found[1]) == pytest.approx(len(found[0]), rel=0.01)
    np.testing.assert_allclose(*(np.median(m.score) for m in found), rtol=0.02)


@pytest.mark.parametrize("quality", ["best", "fast"])
def test_dense_matching_compensates_exposure(pair, quality):
    left, right, truth = pair
    found = [
        match_dense(left, image, max_disparity=16, quality=quality).disparity_px
        for image in (right, exposed_with(right, 1.15, -8))
    ]
    covered = [np.isfinite(one).mean() for one in found]
    errors = [np.nanmedian(np.abs(one - truth)) for one in found]
    assert covered[1] == pytest.approx(covered[0], abs=0.005)
    assert errors[1] == pytest.approx(errors[0], rel=0.1)
