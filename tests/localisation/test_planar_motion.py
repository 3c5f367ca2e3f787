"""The motion of level cameras is recovered, with a consistent covariance."""

from dataclasses import replace

import numpy as np
import pytest

from recon.geometry import invert, pose, transform
from recon.localisation.pairs import told, without
from recon.localisation.planar_motion import planar_motion, standing
from recon.localisation.stance import tilt_by
from recon.sequences.odometry.tracking import Sightings, Tracks
from tests.sequences.drives import RIG, tracks

TILTS = tuple(pose(tilt_by(pitch), [0.0, 0.0, 0.0]) for pitch in (0.02, -0.05))
STEP = np.array([0.4, -0.3, 0.04])
T_FIRST_SECOND = invert(TILTS[0]) @ standing(STEP, TILTS[1])
GUESS = STEP + np.array([0.2, 0.1, 0.02])
SPREAD = np.diag([0.3, 0.3, 0.03]) ** 2
MEDIAN_SQUARE = 2.37
"""Of the norm of three independent standard normal errors."""


def found_in(seen, guess=GUESS, spread=SPREAD):
    return planar_motion(seen, RIG, TILTS, guess, spread)


def test_motion_is_exact_without_noise():
    seen = tracks(np.random.default_rng(0), T_FIRST_SECOND, sigma_px=0.0)
    vague = 1e6 * SPREAD
    np.testing.assert_allclose(found_in(seen, spread=vague).place, STEP, atol=1e-6)


@pytest.mark.parametrize("common_px", [0.0, 0.05])
def test_information_matches_the_errors(common_px):
    """A common error of all disparities, which is not noise, is included."""
    rng, ratios = np.random.default_rng(1), []
    for _ in range(40):
        seen = tracks(rng, T_FIRST_SECOND, number=60, sigma_px=0.2)
        shift = replace(seen.second, disparity_px=seen.second.disparity_px + common_px)
        guess = STEP + rng.multivariate_normal(np.zeros(3), SPREAD)
        found = found_in(Tracks(first=seen.first, second=shift), guess)
        off = found.place - STEP
        ratios.append(off @ (found.information + np.linalg.inv(SPREAD)) @ off / 3.0)
    assert 0.5 < np.sqrt(np.mean(ratios)) < 1.5


def test_false_tracks_are_rejected():
    rng, errors = np.random.default_rng(2), []
    for _ in range(20):
        seen = tracks(rng, T_FIRST_SECOND, number=60, sigma_px=0.2, outliers=0.5)
        errors.append(np.abs(found_in(seen).place - STEP))
    assert (np.median(errors, axis=0) < [0.1, 0.05, 0.005]).all()


def test_tracks_of_two_motions_give_no_motion():
    """Repeating texture: half of the matches follow another motion."""
    rng = np.random.default_rng(3)
    other = invert(TILTS[0]) @ standing(STEP + np.array([0.0, 0.5, 0.0]), TILTS[1])
    one, two = (tracks(rng, T, number=30, sigma_px=0.1) for T in (T_FIRST_SECOND, other))
    both = Tracks(first=joined(one.first, two.first), second=joined(one.second, two.second))
    assert found_in(one) is not None
    assert found_in(both, spread=4.0 * SPREAD) is None


def joined(one, two):
    return Sightings(
        **{
            name: np.concatenate([getattr(one, name), getattr(two, name)])
            for name in Sightings.__slots__
        }
    )


def test_noisy_depths_of_far_points_do_not_shorten_the_motion():
    """The disparities of both pairs are noisy, not only that of the second."""
    rng, errors = np.random.default_rng(4), []
    step = np.array([0.0, 3.0, 0.0])
    T_first_second = invert(TILTS[0]) @ standing(step, TILTS[1])
    depth = RIG.focal_px * RIG.baseline / rng.uniform(0.4, 0.8, 40)
    spread = np.diag([0.01, 6.0, 0.1]) ** 2
    for _ in range(30):
        pixels = rng.uniform([20, 20], [RIG.width - 20, RIG.height - 20], (40, 2))
        first = RIG.rays(pixels) * depth[:, None]
        seen = [first, transform(invert(T_first_second), first)]
        one, two = (sighted(rng, points, 0.1) for points in seen)
        noisy = Tracks(first=one, second=two)
        found = found_in(noisy, step, spread)
        errors.append(found.place[1] - step[1])
    assert abs(np.median(errors)) < 0.15


def sighted(rng, points, sigma_px):
    left, right = RIG.project_left(points), RIG.project_right(points)
    noise = rng.normal(0.0, sigma_px, (len(left), 3))
    return Sightings(
        points_px=left + noise[:, :2],
        disparity_px=left[:, 0] - right[:, 0] + noise[:, 2],
        row_offset_px=np.zeros(len(left)),
    )


def test_coincident_points_give_no_motion():
    seen = tracks(np.random.default_rng(2), T_FIRST_SECOND).select(np.zeros(1, int).repeat(50))
    assert found_in(seen) is None


def test_prior_is_removed_from_an_estimate():
    """The estimate is the mean of points and prior, weighted by their information."""
    rng = np.random.default_rng(5)
    known, alone = np.array([1.0, 2.0, 0.3]), np.array([1.5, 1.8, 0.2])
    spread = np.cov(rng.normal(size=(3, 9)))
    information = np.linalg.inv(np.cov(rng.normal(size=(3, 9))))
    both = np.linalg.solve(
        information + np.linalg.inv(spread), information @ alone + np.linalg.solve(spread, known)
    )
    step, told_information = told(both, information, (known, spread), np.zeros((3, 3)))
    np.testing.assert_allclose(step, alone, atol=1e-9)
    np.testing.assert_allclose(told_information, information, rtol=1e-9)
    weak = np.diag([1e3, 1e-3, 1e-3])
    step, _ = told(both, weak, (known, np.eye(3)), np.zeros((3, 3)))
    np.testing.assert_allclose(step[1:], both[1:])


def far_thing(rng, step, own_px):
    """Points of a far thing, each with an error of its disparity that both pairs share."""
    T_first_second = invert(TILTS[0]) @ standing(step, TILTS[1])
    pixels = rng.uniform([550, 140], [650, 240], (40, 2))
    first = RIG.rays(pixels) * RIG.focal_px * RIG.baseline / 0.75
    own = rng.normal(0.0, own_px, 40)
    one, two = (
        sighted(rng, points, 0.02) for points in (first, transform(invert(T_first_second), first))
    )
    return Tracks(
        first=replace(one, disparity_px=one.disparity_px + own),
        second=replace(two, disparity_px=two.disparity_px + own),
    )


def errors_over_sigma(own_px):
    """Median errors of steps over their sigma: of all that is told, and of what is left of it."""
    rng, ratios = np.random.default_rng(5), []
    spread, least = np.diag([1.0, 1.0, 0.02]) ** 2, np.diag([0.02, 0.02, 0.001]) ** 2
    for _ in range(25):
        step = rng.multivariate_normal(np.zeros(3), spread)
        found = found_in(far_thing(rng, step, own_px), np.zeros(3), spread)
        place, information = told(found.place, found.information, (np.zeros(3), spread), least)
        off, left = place - step, without(information, found.feigned)
        ratios.append([off @ information @ off, off @ left @ off])
    return np.sqrt(np.median(ratios, axis=0) / MEDIAN_SQUARE)


def test_errors_of_depths_that_both_pairs_share_feign_no_information():
    """Points of a far thing seem to be at several distances, and yet move alike."""
    before, after = errors_over_sigma(0.15)
    assert before > 4.0
    assert 0.5 < after < 1.5


def test_depths_of_near_points_are_not_feigned():
    found = found_in(tracks(np.random.default_rng(6), T_FIRST_SECOND, number=60))
    left = without(found.information, found.feigned)
    share = np.linalg.eigvals(np.linalg.solve(found.information, left)).real
    assert 0.9 < share.min() <= share.max() < 1.0
