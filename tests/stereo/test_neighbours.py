"""Matches agree with the matches around them if these lie on the same surface."""

import numpy as np
import pytest

from recon.stereo.neighbours import neighbours


@pytest.fixture
def pixels():
    rng = np.random.default_rng(3)
    v, u = np.divmod(np.sort(rng.choice(160 * 120, 2000, replace=False)), 160)
    return u, v


def share(pixels, disparity):
    u, v = pixels
    return neighbours(u, v, np.rint(disparity).astype(np.int64), np.arange(len(u))).agreement


def inner(pixels):
    u, v = pixels
    return (u > 24) & (u < 136) & (v > 24) & (v < 96)


@pytest.mark.parametrize("slant", [0.0, 0.1, 0.35])
def test_matches_of_a_plane_agree(pixels, slant):
    _, v = pixels
    found = share(pixels, 10 + slant * v)[inner(pixels)]
    assert found.mean() > 0.75
    level = share(pixels, 10 + 0 * v)[inner(pixels)]
    assert level.min() > 0.85


def test_matches_at_random_disagree(pixels):
    rng = np.random.default_rng(4)
    chance = share(pixels, rng.integers(0, 128, 2000))
    assert chance[inner(pixels)].mean() < 0.2
    lone = rng.choice(2000, 20, replace=False)
    disparity = np.full(2000, 10)
    disparity[lone] = 60
    found = share(pixels, disparity)
    assert found[lone].max() < 0.2 < 0.7 < np.delete(found, lone).min()


def test_both_sides_of_a_step_agree_half(pixels):
    u, _ = pixels
    found = share(pixels, np.where(u < 80, 30, 10))
    at_edge = inner(pixels) & (abs(u - 80) < 6)
    far = inner(pixels) & (abs(u - 80) > 30)
    assert 0.3 < found[at_edge].mean() < 0.8 < found[far].min()


def test_company_is_also_missing_beside_empty_sky(pixels):
    u, v = (column[pixels[1] > 60] for column in pixels)
    found = neighbours(u, v, np.full(len(u), 10), np.arange(len(u)))
    near, far = v < 68, (v > 84) & (u > 24) & (u < 136) & (v < 96)
    assert found.agreement[near].mean() > 0.85
    assert 0.3 < found.company[near].mean() < 0.7 < 0.95 < found.company[far].mean()


def test_a_match_without_neighbours_is_undecided():
    one = np.array([5])
    alone = neighbours(one, one, one, one)
    assert (alone.agreement.tolist(), alone.company.tolist()) == ([0.5], [0.0])
    assert len(neighbours(one[:0], one[:0], one[:0], one[:0]).agreement) == 0


def test_most_confident_match_of_a_block_votes():
    u, v = np.array([4, 17, 18]), np.array([4, 4, 4])
    disparity = np.array([7, 7, 40])
    with_it, against_it = (
        neighbours(u, v, disparity, np.array(order)).agreement[0]
        for order in ([2, 0, 1], [2, 1, 0])
    )
    assert with_it > 0.5 > against_it
