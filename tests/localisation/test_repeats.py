"""A texture that goes several times around a solid is known where no pair has shown it."""

import numpy as np
import pytest

from recon.localisation.repeats import completed, repeats

AROUND, ALONG = 60, 20


def around(rng, times):
    """A texture that goes so many times around."""
    one = rng.uniform(0.0, 255.0, (AROUND // times, ALONG, 3))
    return np.concatenate([one] * times)


@pytest.mark.parametrize("times", [2, 3])
def test_unseen_sides_have_the_colours_that_repeat(times):
    texture = around(np.random.default_rng(0), times)
    seen = np.ones((AROUND, ALONG), bool)
    seen[5:15] = False
    shown = np.where(seen[..., None], texture, 0.0)
    found, known = completed(shown, seen, repeats(shown, seen))
    assert known.all()
    assert np.abs(found - texture).max() < 1e-9


def test_texture_that_goes_once_around_stays_unknown_where_unseen():
    texture = around(np.random.default_rng(0), 1)
    seen = np.ones((AROUND, ALONG), bool)
    seen[5:15] = False
    assert not repeats(texture, seen)


def test_sides_that_cannot_be_compared_stay_unknown():
    texture = around(np.random.default_rng(0), 2)
    seen = np.zeros((AROUND, ALONG), bool)
    seen[:28] = True
    assert not repeats(texture, seen)
