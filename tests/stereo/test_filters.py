"""The separable filters equal Eq 11, steer as in Eqs 12 and 13, and have the right phase."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import correlate

from recon.stereo import filters

RNG = np.random.default_rng(3)
IMAGE = RNG.integers(0, 256, (40, 50)).astype(np.uint8)


def eq_11(width, theta):
    """Sample G - jH on the square of the separable taps, with the mean of G removed."""
    radius = len(filters.taps(width).columns) - 1
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1] / width
    u = x * np.cos(theta) + y * np.sin(theta)
    gauss = np.exp(-x * x - y * y)
    g = (0.934 - 3.738 * u**2 + 1.246 * u**4) * gauss
    h = (2.858 * u - 2.982 * u**3 + 0.3975 * u**5) * gauss
    return (g - 1j * h) / width**2


def planes_of(image, width, descriptor):
    """Compute real and imaginary responses (2, H, W)."""
    planes = filters.respond(image, (width,)).planes[:, 0, descriptor, :, : image.shape[1]]
    return np.moveaxis(planes, 0, 1)


@pytest.mark.parametrize("width", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("descriptor", [0, 1, 2])
def test_separable_filters_equal_eq_11(width, descriptor):
    planes = planes_of(IMAGE, width, descriptor)
    kernel = eq_11(width, np.pi / 3 * descriptor)
    wanted = [correlate(IMAGE.astype(float), k, mode="nearest") for k in (kernel.real, kernel.imag)]
    # The mean that truncation leaves in G is removed in the factors, so constants may differ.
    error = planes[1] - wanted[1]
    assert np.abs(error).max() < 2e-3 * np.abs(wanted[1]).max()
    assert np.std(planes[0] - wanted[0]) < 0.05 * np.std(wanted[0])


def wave(wavelength, angle=0.0, shape=(40, 80)):
    v, u = np.indices(shape)
    phase = 2 * np.pi / wavelength * (u * np.cos(angle) + v * np.sin(angle))
    return np.rint(128 + 60 * np.cos(phase)).astype(np.uint8)


@pytest.mark.parametrize("width", [2.0, 3.0, 4.0, 6.0])
def test_phase_grows_to_the_right_by_the_wavenumber(width):
    wavelength = filters.WAVELENGTH_OF_WIDTH * width
    real, imag = planes_of(wave(wavelength), width, 0)
    row = (real + 1j * imag)[20, 30:50]
    turn = np.angle(row[1:] * row[:-1].conj())
    assert np.median(turn) == pytest.approx(2 * np.pi / wavelength, rel=0.03)
    assert np.median(turn) > 0  # the other sign would invert every sub-pixel correction


@pytest.mark.parametrize("width", [2.0, 4.0])
def test_wave_of_the_filters_length_responds_most(width):
    def response(factor):
        image = wave(factor * filters.WAVELENGTH_OF_WIDTH * width)
        return filters.respond(image, (width,)).modulus[20, 40]

    assert response(1.0) > 1.2 * max(response(0.6), response(1.8))


@settings(max_examples=20)
@given(st.floats(0, np.pi, exclude_max=True))
def test_doubled_angle_is_that_of_the_normal(angle):
    responses = filters.respond(wave(7.0, angle, (41, 41)), (2.0, 4.0))
    found = np.arctan2(responses.sine[20, 20], responses.cosine[20, 20])
    assert abs(np.angle(np.exp(1j * (found - 2 * angle)))) < 2 * np.radians(3)


@pytest.mark.parametrize("value", [0, 100, 255])
def test_constant_image_gives_no_response(value):
    image = np.full((30, 30), value, np.uint8)
    assert filters.respond(image, (1.5, 3.0, 6.0)).modulus.max() < 0.05


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (2, 3)])
def test_images_smaller_than_the_filters_are_filtered(shape):
    responses = filters.respond(np.full(shape, 9, np.uint8), (1.5, 6.0))
    height, width = shape
    assert responses.planes.shape == (height, 2, 3, 2, 8 * -(-width // 8))
    assert responses.modulus.shape == shape
    assert np.isfinite(responses.planes).all()


def test_energy_is_the_sum_over_all_directions():
    thetas = np.arange(24) * np.pi / 24
    kernels = [eq_11(3.0, theta) for theta in thetas]
    image = IMAGE.astype(float)
    energy = np.array([
        correlate(image, k.real - k.real.mean(), mode="nearest") ** 2
        + correlate(image, k.imag, mode="nearest") ** 2
        for k in kernels
    ])[:, 10:-10, 10:-10]  # fmt: skip
    found = [part[10:-10, 10:-10] for part in filters.respond(IMAGE, (3.0,))[1:]]
    cosine, sine = (2 * np.tensordot(f(2 * thetas), energy, 1) / 24 for f in (np.cos, np.sin))
    strength = np.sqrt(energy.mean(axis=0) + np.hypot(cosine, sine))
    for part, wanted in zip(found, (strength, cosine, sine), strict=True):
        assert np.abs(part - wanted).max() < 0.03 * np.abs(wanted).max()
