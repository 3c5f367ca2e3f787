"""Gaps between the views of an obstacle, and the views that close them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.exploration.gaps import LAST, LEAST, values_of

NUM_BEARINGS, SIDE = 72, 28.2


def after(*middles):
    """Find the bearings that views along some central bearings leave missing."""
    missing = np.ones(NUM_BEARINGS, dtype=bool)
    for middle in middles:
        missing[(middle - 14 + np.arange(28)) % NUM_BEARINGS] = False
    return missing


def value(missing, middle):
    return values_of(missing, SIDE)[0, (middle - 14) % NUM_BEARINGS]


def test_first_of_three_even_views_are_worth_most():
    first, second, last = value(after(), 0), value(after(0), 24), value(after(0, 24), 48)
    assert first == pytest.approx(1.0, abs=0.05)
    assert 0.8 < second < first
    assert LAST <= last < second


def test_second_view_that_leaves_two_gaps_is_worth_little():
    assert 0.0 < value(after(0), 36) <= LEAST
    assert value(after(0), 36) < value(after(0), 17) < value(after(0), 24)


def test_view_of_known_sides_is_worth_nothing():
    assert value(after(0), 0) == 0.0
    assert not values_of(np.zeros(NUM_BEARINGS, dtype=bool), SIDE).any()


@settings(max_examples=50)
@given(
    st.lists(st.booleans(), min_size=NUM_BEARINGS, max_size=NUM_BEARINGS),
    st.integers(0, NUM_BEARINGS),
)
def test_values_rotate_with_the_gaps(missing, turned):
    missing = np.array(missing)
    values = values_of(missing, SIDE)
    assert values.min() >= 0.0
    assert values_of(np.roll(missing, turned), SIDE) == pytest.approx(
        np.roll(values, turned, axis=1)
    )
