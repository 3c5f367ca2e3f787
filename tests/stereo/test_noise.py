"""Injected noise is measured, and results under noise are not overconfident."""

import cv2
import numpy as np
import pytest

from recon.mapping.pair import match_pair
from recon.records import ImageNoise
from recon.settings import FeatureSettings
from recon.stereo.features import detect
from recon.stereo.noise import floor_modulus, gain, step_modulus

SHAPE = (192, 256)


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def scene(rng, shape=SHAPE, calm_rows=72):
    """Make a texture below an untextured part, in grey levels (H, W) as floats."""
    texture = cv2.GaussianBlur(rng.normal(0, 60, shape), (0, 0), 1.2)
    texture[:calm_rows] = 0
    return 120 + texture


def exposed(light, sigma, rng, grain_px=0.0):
    noise = rng.normal(0, 1, light.shape) * sigma
    if grain_px:
        noise = cv2.GaussianBlur(noise, (0, 0), grain_px)
    return np.clip(np.rint(light + noise), 0, 255).astype(np.uint8)


def noise_of(image) -> ImageNoise:
    return detect(image, FeatureSettings()).noise


@pytest.mark.parametrize("sigma", [1.0, 3.0, 6.0, 12.0])
def test_injected_noise_is_measured(sigma, rng):
    noise = noise_of(exposed(scene(rng), sigma, rng))
    assert 0.85 * sigma < noise.level < 1.2 * sigma
    assert (noise.by_scale >= 0.99 * noise.level).all()


def test_noiseless_image_has_rounding_noise(rng):
    assert noise_of(exposed(scene(rng), 0.0, rng)).level == pytest.approx(12**-0.5)


def test_black_image_has_rounding_noise():
    noise = noise_of(np.zeros(SHAPE, np.uint8))
    assert noise.by_grey == pytest.approx(12**-0.5)


def test_signal_dependent_noise_is_measured(rng):
    light = np.tile(np.linspace(20, 220, SHAPE[1]), (SHAPE[0], 1))
    noise = noise_of(exposed(light, 0.5 * np.sqrt(light), rng))
    for grey in (40, 120, 200):
        assert 0.75 < noise.by_grey[grey] / (0.5 * np.sqrt(grey)) < 1.3


def test_dark_texture_is_not_taken_for_noise(rng):
    light = scene(rng, calm_rows=0) - 60
    light[:72] = 200
    noise = noise_of(exposed(light, 2.0, rng))
    assert noise.by_grey.max() < 3.0


def test_grain_is_measured_by_the_wider_filters(rng):
    white, grain = (noise_of(exposed(scene(rng), 5.0, rng, g)) for g in (0.0, 0.8))
    # Second differences hardly respond to grain, but the filters do.
    assert grain.level < 0.25 * white.level
    assert (grain.by_scale[1:] > 1.5 * grain.level).all()


def test_gain_is_the_response_to_white_noise(rng):
    image = np.clip(rng.normal(128, 20, (256, 256)), 0, 255).astype(np.uint8)
    planes = detect(image, FeatureSettings(widths_px=(1.5, 2.0, 6.0))).planes
    energy = (planes[20:-20, ..., 20:236] ** 2).sum(axis=3).mean(axis=(0, 2, 3)) / 400
    np.testing.assert_allclose(energy, [gain(1.5), gain(2.0), gain(6.0)], rtol=0.2)


def test_feature_floor_follows_the_noise(rng):
    widths = (1.5, 3.0, 6.0)
    silent, loud = (
        floor_modulus(noise_of(exposed(scene(rng), sigma, rng)), widths) for sigma in (0.0, 8.0)
    )
    assert step_modulus(widths) < silent < 3 * step_modulus(widths)
    assert loud > 4 * silent
    steps = np.tile((np.arange(SHAPE[1]) // 16 + 90).astype(np.uint8), (SHAPE[0], 1))
    assert len(detect(steps, FeatureSettings())) == 0
    assert len(detect(4 * (steps - 80), FeatureSettings())) > 0


@pytest.mark.parametrize("quality", ["fast", "best"])
@pytest.mark.parametrize("sigma", [0.0, 2.0, 5.0, 10.0])
def test_sigma_and_probability_are_consistent_under_noise(quality, sigma, rng):
    shift = 5.3
    light = scene(rng, (SHAPE[0], SHAPE[1] + 16))
    u, v = np.meshgrid(np.arange(SHAPE[1], dtype=np.float32), np.arange(SHAPE[0]))
    left, right = (
        cv2.remap(light.astype(np.float32), u + k, v.astype(np.float32), cv2.INTER_CUBIC)
        for k in (3.0, 3.0 + shift)
    )
    matches = match_pair(
        exposed(left, sigma, rng),
        exposed(right, sigma, rng),
        max_disparity=15,
        quality=quality,
        residual_px=0.0,
    )
    error = matches.disparity_px - shift
    right_ones = np.abs(error) <= 1
    # A plain wall is easy; sigma also covers errors that do not occur on it.
    spread = np.sqrt(np.mean((error[right_ones] / matches.sigma_px[right_ones]) ** 2))
    assert 0.15 < spread < 1.1
    # Matches on such an easy wall are correct more often than others of equal score and noise.
    assert -0.35 < matches.probability.mean() - right_ones.mean() < 0.05
    sure = (matches.probability >= 0.5) & ~matches.is_whole
    assert right_ones[sure].mean() > 0.97
    in_the_calm = matches.points_px[:, 1] < 60
    assert sure[in_the_calm].sum() <= 0.02 * sure.sum()
