"""The fast approximation of the angle is accurate."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from recon.stereo.kernels.angle import angles

parts = arrays(np.float32, 16, elements=st.floats(-1e6, 1e6, width=32, allow_subnormal=False))


def found(real, imag):
    out = np.empty_like(real)
    angles(real, imag, out)
    return out


def test_angle_is_accurate_around_the_circle_and_at_every_magnitude():
    turn = np.linspace(-np.pi, np.pi, 10_001)[1:-1]
    for size in (1e-6, 1.0, 1e6):
        out = found(*((size * part(turn)).astype(np.float32) for part in (np.cos, np.sin)))
        assert np.abs(out - turn).max() < 1e-6


@given(parts, parts)
def test_angle_matches_numpy(real, imag):
    real[real == 0] = 0.0  # signed zeros are not distinguished here
    imag[imag == 0] = 0.0
    assert np.abs(found(real, imag) - np.arctan2(imag, real)).max() < 1e-6


def test_angle_of_axes_and_zero():
    real = np.array([1, 0, -1, 0, 0], np.float32)
    imag = np.array([0, 1, 0, -1, 0], np.float32)
    wanted = [0, np.pi / 2, np.pi, -np.pi / 2, 0]
    np.testing.assert_allclose(found(real, imag), wanted, atol=1e-6)
