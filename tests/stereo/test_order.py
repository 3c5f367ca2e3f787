"""The fast sort is stable, and the fast median matches numpy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from recon.stereo.kernels.sorting import falling, median, order


@given(arrays(np.float32, st.integers(0, 60), elements=st.floats(-3, 3, width=16)))
def test_descending_order_of_floats_is_stable(values):
    np.testing.assert_array_equal(falling(values), np.argsort(-values, kind="stable"))


@given(arrays(np.int64, st.integers(0, 60), elements=st.integers(-9, 9)))
def test_order_of_integers_is_stable(keys):
    np.testing.assert_array_equal(order(keys), np.argsort(keys, kind="stable"))


@pytest.mark.parametrize("extreme", [2**31 - 1, -(2**31)])
def test_order_accepts_all_32_bit_integers(extreme):
    np.testing.assert_array_equal(order(np.array([extreme, 0])), [1, 0] if extreme > 0 else [0, 1])


@given(arrays(np.float64, st.integers(1, 40), elements=st.floats(-3, 3, width=16)))
def test_median_matches_numpy(values):
    assert median(values) == np.median(values)
