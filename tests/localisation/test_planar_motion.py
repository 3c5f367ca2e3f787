"""The motion of level cameras is recovered, with a consistent covariance."""

from dataclasses import replace

import numpy as np
import pytest

from recon.geometry import invert, pose
from recon.localisation.planar_motion import planar_motion, standing
from recon.localisation.stance import tilt_by
from recon.sequences.odometry.tracking import Tracks
from tests.sequences.drives import RIG, tracks

TILTS = tuple(pose(tilt_by(pitch), [0.0, 0.0, 0.0]) for pitch in (0.02, -0.05))
STEP = np.array([0.4, -0.3, 0.04])
T_FIRST_SECOND = invert(TILTS[0]) @ standing(STEP, TILTS[1])
GUESS = STEP + np.array([0.2, 0.1, 0.02])


def test_motion_is_exact_without_noise():
    seen = tracks(np.random.default_rng(0), T_FIRST_SECOND, sigma_px=0.0)
    found = planar_motion(seen, RIG, TILTS, GUESS)
    np.testing.assert_allclose(found.place, STEP, atol=1e-6)


@pytest.mark.parametrize("common_px", [0.0, 0.05])
def test_covariance_matches_the_errors(common_px):
    """A common error of all disparities, which is not noise, is included."""
    rng, ratios = np.random.default_rng(1), []
    for _ in range(40):
        seen = tracks(rng, T_FIRST_SECOND, number=60, sigma_px=0.2)
        shift = replace(seen.second, disparity_px=seen.second.disparity_px + common_px)
        found = planar_motion(Tracks(first=seen.first, second=shift), RIG, TILTS, GUESS)
        off = found.place - STEP
        ratios.append(off @ np.linalg.solve(found.covariance, off) / 3.0)
    assert 0.5 < np.sqrt(np.mean(ratios)) < 1.5


def test_coincident_points_give_no_motion():
    seen = tracks(np.random.default_rng(2), T_FIRST_SECOND).select(np.zeros(1, int).repeat(50))
    assert planar_motion(seen, RIG, TILTS, GUESS) is None
