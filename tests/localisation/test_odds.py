"""Objects speak for a pose one by one: a small one beside a large one is not lost in it."""

import numpy as np
import pytest

from recon.localisation.odds import log_odds

WALL, TREE = 1, 2


def pixels(numbers, values):
    """Objects and log densities of so many pixels of each."""
    return np.repeat(list(numbers), list(numbers.values())), np.repeat(
        values, list(numbers.values())
    )


def test_a_small_object_tells_two_sides_of_a_large_one_apart():
    things, off = pixels({WALL: 20_000, TREE: 300}, [-0.05, 5.0])
    assert log_odds(things, off, 1) > 20.0
    assert log_odds(np.full_like(things, WALL), off, 1) < 1.0


def test_errors_of_a_surface_are_those_of_all_its_pixels():
    few, many = (log_odds(*pixels({WALL: n}, [0.05]), 1) for n in (10_000, 40_000))
    assert many == pytest.approx(few, rel=0.2)


def test_pixels_that_are_alike_do_not_count():
    things, off = pixels({WALL: 100, TREE: 50}, [0.0, 1.0])
    assert log_odds(things, off, 1) == log_odds(things[100:], off[100:], 1)


def test_large_pixels_count_as_those_of_the_image():
    things, off = pixels({TREE: 400}, [1.0])
    assert log_odds(things[:100], 4.0 * off[:100], 2) == log_odds(things, off, 1)


def test_the_lack_of_an_object_speaks_against_a_pose_up_to_a_limit():
    things, off = pixels({WALL: 20_000, -TREE: 300}, [-0.001, 5.0])
    assert 4.0 < log_odds(things, off, 1) < 10.0
    assert log_odds(things, -off, 1) < -20.0
