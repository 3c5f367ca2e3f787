"""The motion behind the tracks is recovered as accurately as their noise allows."""

import numpy as np
import pytest

from recon.geometry import invert
from recon.sequences.calibration.row_error import Field, Residual
from recon.sequences.calibration.selfcalibration import estimate_residual
from recon.sequences.odometry.motion import (
    estimate_motion,
    linearise,
    motion_changed,
    refine_motion,
)
from tests.sequences.drives import RIG, motion, tracks


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def test_motion_is_exact_without_noise(rng):
    T_first_second = motion(rng)
    found = estimate_motion(tracks(rng, T_first_second, sigma_px=0.0), RIG)
    np.testing.assert_allclose(invert(found), T_first_second, atol=1e-6)


def test_noise_in_is_noise_out(rng):
    """Twice the noise gives twice the error, in medians over many drives."""
    errors = []
    for sigma_px in (0.1, 0.2):
        steps = []
        for _ in range(40):
            T = motion(rng)
            found = estimate_motion(tracks(rng, T, sigma_px=sigma_px), RIG)
            steps.append(np.linalg.norm((invert(found) - T)[:3, 3]))
        errors.append(np.median(steps))
    assert 0.0001 < errors[0] < 0.002
    assert 1.5 < errors[1] / errors[0] < 3.0


def test_motion_is_robust_to_a_third_of_wrong_tracks(rng):
    T = motion(rng)
    found = estimate_motion(tracks(rng, T, outliers=0.33), RIG)
    assert np.linalg.norm((invert(found) - T)[:3, 3]) < 0.03


def test_too_few_tracks_give_no_motion(rng):
    assert estimate_motion(tracks(rng, motion(rng), number=8), RIG) is None
    assert estimate_motion(tracks(rng, motion(rng), number=60, outliers=1.0), RIG) is None


def test_coincident_points_give_no_motion(rng):
    seen = tracks(rng, motion(rng)).select(np.zeros(1, int).repeat(50))
    assert estimate_motion(seen, RIG) is None


def test_derivatives_match_finite_differences(rng):
    T_first_second = motion(rng)
    seen, T = tracks(rng, T_first_second, number=30, sigma_px=0.0), invert(T_first_second)
    at = linearise(T, seen, RIG)
    for column, change in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (
            linearise(motion_changed(T, s * change), seen, RIG).residual for s in (1, -1)
        )
        numeric = (ahead - behind) / 2e-6
        np.testing.assert_allclose(numeric, at.by_motion[:, :, column], rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize(
    "field",
    [
        pytest.param([0, 0, 0, 0, 0, 0], id="none"),
        pytest.param([1.2, 0, 0, 0, 0, 0], id="constant"),
        pytest.param([0.3, 0, 0, 1.1, 0, 0], id="vergence"),
        pytest.param([0.5, 0.4, -0.3, 0.9, 0.2, -0.4], id="quadratic"),
    ],
)
def test_rectification_residual_is_estimated_and_removed(rng, field):
    drives = [motion(rng) for _ in range(8)]
    seen = [tracks(rng, T, field=np.array(field)) for T in drives]
    residual = estimate_residual(seen, RIG)
    np.testing.assert_allclose(residual.disparity.coefficients, field, atol=0.12)
    assert residual.row.coefficients.any() == 0
    assert abs(_scale_error(seen, drives, residual)) < 0.01


def test_uncorrected_residual_biases_the_scale(rng):
    drives = [motion(rng) for _ in range(4)]
    seen = [tracks(rng, T, field=np.array([1.2, 0, 0, 0, 0, 0])) for T in drives]
    assert _scale_error(seen, drives, Residual()) > 0.03


def _scale_error(seen, drives, residual):
    found = [estimate_motion(residual.corrected(t, RIG), RIG) for t in seen]
    lengths = [np.linalg.norm(invert(T)[:3, 3]) for T in found]
    return sum(lengths) / sum(np.linalg.norm(T[:3, 3]) for T in drives) - 1


def test_static_rig_gives_no_residual(rng):
    seen = [tracks(rng, np.eye(4), field=np.array([1.2, 0, 0, 0, 0, 0])) for _ in range(4)]
    assert np.abs(estimate_residual(seen, RIG).disparity.coefficients).max() < 0.5


def test_no_tracks_give_no_residual(rng):
    empty = [tracks(rng, np.eye(4)).select(np.zeros(0, int)) for _ in range(4)]
    assert not estimate_residual(empty, RIG).disparity.coefficients.any()
    assert estimate_residual([], RIG).maps(RIG) is None


def test_correction_maps_sample_the_true_position():
    field = Field(coefficients=np.array([0.5, 0.2, 0, 1.0, 0, 0]))
    u, v = Residual(disparity=field).maps(RIG)
    np.testing.assert_allclose(
        u[0, [0, 600, 1199]], [0.5 - 0.2 + 1.0, 600.5, 1199 + 1.7], atol=1e-2
    )
    np.testing.assert_array_equal(v[:, 7], np.arange(RIG.height))


def test_few_hundred_tracks_are_too_few_for_a_residual(rng):
    field = np.array([1.2, 0, 0, 0, 0, 0])
    seen = [tracks(rng, motion(rng), number=60, field=field) for _ in range(8)]
    assert not estimate_residual(seen, RIG).disparity.coefficients.any()


@pytest.mark.parametrize("kind", ["one point", "one line", "no depth", "behind"])
def test_degenerate_tracks_give_no_motion_or_a_finite_one(rng, kind):
    seen = tracks(rng, motion(rng))
    first, second = seen.first, seen.second
    if kind == "one point":
        seen = seen.select(np.zeros(50, np.int64))
    elif kind == "one line":
        first.points_px[:, 1] = second.points_px[:, 1] = 183.0
        first.disparity_px[:] = second.disparity_px[:] = 20.0
    elif kind == "no depth":
        first.disparity_px[:] = second.disparity_px[:] = 1e-9
    else:
        second.disparity_px[:] *= -1
    found = estimate_motion(seen, RIG)
    assert found is None or np.isfinite(found).all()
    refined = refine_motion(np.eye(4), seen, RIG)
    assert refined is None or np.isfinite(refined).all()
