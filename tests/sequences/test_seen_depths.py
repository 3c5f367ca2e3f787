"""Depths are compared with the same neighbours that a search tree finds."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from recon.mapping.seendepths import MAX_OFFSET_PX, NUM_CANDIDATES, NUM_SIGMAS, SeenDepths

SIZE = (60, 40)


def differences_by_tree(seen, given):
    _, near = cKDTree(seen[0]).query(given[0], k=NUM_CANDIDATES, distance_upper_bound=MAX_OFFSET_PX)
    depth, sigma = np.append(seen[1], np.inf)[near], np.append(seen[2], 0.0)[near]
    limit = NUM_SIGMAS * np.hypot(sigma, given[2][:, None])
    return (np.abs(depth - given[1][:, None]) <= limit).any(axis=1)


def points(rng, number, low, high):
    at = rng.uniform(low, high, (number, 2)) * SIZE
    return at, rng.uniform(5, 9, number), rng.uniform(0.05, 0.4, number)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-0.2, 1.2), (0.9, 1.5)])
def test_nearest_points_are_compared_inside_and_outside_the_image(low, high):
    rng = np.random.default_rng(3)
    seen, given = points(rng, 400, low, high), points(rng, 500, low, high)
    found = SeenDepths(*seen, SIZE).agree(*given)
    assert (found == differences_by_tree(seen, given)).all()
    assert 0.05 < found.mean() < 0.95


def test_point_without_a_position_agrees_with_nothing():
    rng = np.random.default_rng(4)
    at, depth, sigma = points(rng, 5, 0.0, 1.0)
    at[0], at[1] = np.nan, (np.inf, 1e300)
    seen = points(rng, 4000, 0.0, 1.0)
    found = SeenDepths(*seen, SIZE).agree(at, depth, np.full(5, 9.0))
    assert found.tolist() == [False, False, True, True, True]
    nothing = np.zeros((0, 2)), np.zeros(0), np.zeros(0)
    assert not SeenDepths(*nothing, SIZE).agree(at, depth, sigma).any()
    assert not len(SeenDepths(*seen, SIZE).agree(*nothing))
