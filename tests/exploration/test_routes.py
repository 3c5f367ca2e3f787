"""Orders of a tour, against the best of all orders where these can be listed."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from recon.exploration.routes import improved, nearest_first, shortest


def legs_of(number, seed):
    stops = np.random.default_rng(seed).uniform(-50, 50, (number, 2))
    return cdist(stops, stops)


def length_of(order, legs):
    return legs[order[:-1], order[1:]].sum()


def best_length(legs):
    others = itertools.permutations(range(1, len(legs)))
    return min(length_of([0, *order], legs) for order in others)


@settings(max_examples=30)
@given(st.integers(1, 9), st.integers(0, 1000))
def test_two_opt_keeps_the_stops_and_never_lengthens_the_tour(number, seed):
    legs = legs_of(number, seed)
    before = nearest_first(legs)
    after = improved(before, legs)
    assert after[0] == before[0] == 0
    assert sorted(after) == list(range(number))
    assert length_of(after, legs) <= length_of(before, legs) + 1e-9


def test_crossing_is_removed():
    stops = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10], [20, 5]])
    legs = cdist(stops, stops)
    assert length_of(improved([0, 2, 1, 3, 4], legs), legs) < length_of([0, 2, 1, 3, 4], legs)


def test_short_tours_are_the_best_of_all():
    for seed in range(20):
        legs = legs_of(8, seed)
        order = shortest(legs)
        assert order[0] == 0
        assert sorted(order) == list(range(8))
        assert length_of(order, legs) == pytest.approx(best_length(legs))


def test_two_opt_alone_misses_the_best_tour():
    excess = [
        length_of(improved(list(range(8)), legs), legs) / best_length(legs)
        for legs in (legs_of(8, seed) for seed in range(20))
    ]
    assert max(excess) > 1.05


@settings(max_examples=30)
@given(st.integers(1, 25), st.integers(0, 1000))
def test_long_tours_keep_their_stops_and_are_no_longer_than_by_two_opt(number, seed):
    legs = legs_of(number, seed)
    order = shortest(legs)
    assert order[0] == 0
    assert sorted(order) == list(range(number))
    assert length_of(order, legs) <= length_of(improved(nearest_first(legs), legs), legs) + 1e-9


def test_a_tour_without_a_shorter_one_stays():
    legs = cdist(np.arange(6.0)[:, None], np.arange(6.0)[:, None])
    assert shortest(legs) == list(range(6))
