"""Textures have the mean colours of what is seen from afar, and the finest ones that are known."""

import numpy as np

from recon.localisation.scales import COLOUR_SIGMA, LEVELS, scales

AROUND, ALONG = 96, 48


def texture(rng):
    return rng.uniform(0.0, 255.0, (AROUND, ALONG, 3))


def test_coarser_levels_are_means():
    colours = texture(np.random.default_rng(0))
    levels = scales(np.full((AROUND, ALONG), 3.0), colours)
    assert [level.sigma.shape for level in levels] == [
        (AROUND >> n, ALONG >> n) for n in range(LEVELS)
    ]
    np.testing.assert_allclose(levels[0].mean, colours, atol=1e-9)
    np.testing.assert_allclose(levels[1].mean[0, 0], colours[:2, :2].mean(axis=(0, 1)), atol=1e-9)
    assert all((level.sigma == COLOUR_SIGMA).all() and level.is_clear.all() for level in levels)


def test_what_is_seen_from_afar_is_known_at_coarse_levels_only():
    rng = np.random.default_rng(1)
    width = np.full((AROUND, ALONG), 3.0)
    width[: AROUND // 4] = 0.4
    colours = texture(rng)
    fine, coarser = scales(width, colours)[:2]
    np.testing.assert_allclose(fine.mean[:2, :2], coarser.mean[:1, :1].repeat(2, 0).repeat(2, 1))
    assert (fine.sigma[: AROUND // 4] > 30.0).all()
    assert (coarser.sigma == COLOUR_SIGMA).all()
    assert not fine.is_clear[: AROUND // 4].any()


def test_an_exact_repeat_of_what_a_pair_showed_is_as_clear():
    colours = texture(np.random.default_rng(2))
    colours[AROUND // 2 :] = colours[: AROUND // 2]
    width = np.full((AROUND, ALONG), 3.0)
    width[: AROUND // 8] = 0.0
    repeating = scales(width, np.where(width[..., None] > 0.0, colours, 0.0))
    assert all(level.is_clear.all() for level in repeating)
    np.testing.assert_allclose(repeating[0].mean, colours, atol=1e-9)


def test_a_solid_that_no_pair_shows_has_no_colour():
    levels = scales(np.zeros((AROUND, ALONG)), np.zeros((AROUND, ALONG, 3)))
    assert all((level.sigma == 80.0).all() and not level.is_clear.any() for level in levels)
