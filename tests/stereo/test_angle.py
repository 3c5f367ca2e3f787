"""The quick angle is the angle, and the quick order is the stable one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from recon.stereo.angle import angles
from recon.stereo.order import falling, order

parts = arrays(np.float32, 16, elements=st.floats(-1e6, 1e6, width=32, allow_subnormal=False))


def found(real, imag):
    out = np.empty_like(real)
    angles(real, imag, out)
    return out


def test_all_round_the_circle_and_at_every_size():
    turn = np.linspace(-np.pi, np.pi, 10_001)[1:-1]
    for size in (1e-6, 1.0, 1e6):
        out = found(*((size * part(turn)).astype(np.float32) for part in (np.cos, np.sin)))
        assert np.abs(out - turn).max() < 1e-6


@given(parts, parts)
def test_it_is_numpys(real, imag):
    real[real == 0] = 0.0  # a zero has no sign here
    imag[imag == 0] = 0.0
    assert np.abs(found(real, imag) - np.arctan2(imag, real)).max() < 1e-6


def test_axes_and_nothing():
    real = np.array([1, 0, -1, 0, 0], np.float32)
    imag = np.array([0, 1, 0, -1, 0], np.float32)
    wanted = [0, np.pi / 2, np.pi, -np.pi / 2, 0]
    np.testing.assert_allclose(found(real, imag), wanted, atol=1e-6)


@given(arrays(np.float32, st.integers(0, 60), elements=st.floats(-3, 3, width=16)))
def test_falling_is_the_stable_order_of_floats(values):
    np.testing.assert_array_equal(falling(values), np.argsort(-values, kind="stable"))


@given(arrays(np.int64, st.integers(0, 60), elements=st.integers(-9, 9)))
def test_order_is_the_stable_order_of_integers(keys):
    np.testing.assert_array_equal(order(keys), np.argsort(keys, kind="stable"))


@pytest.mark.parametrize("extreme", [2**31 - 1, -(2**31)])
def test_order_takes_what_fits_into_32_bits(extreme):
    np.testing.assert_array_equal(order(np.array([extreme, 0])), [1, 0] if extreme > 0 else [0, 1])
