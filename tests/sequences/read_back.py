"""Reading of the recordings of the tests, and what they must contain."""

import numpy as np

from recon.sequences import open_sequence
from recon.settings import SequenceSettings
from tests.sequences.recordings import NUM_PAIRS, image_pairs

DRIVEN = [0.0, -0.7, -1.4, -2.1]
"""Positions of the pairs along z."""


def read(path, **settings):
    return list(open_sequence(path, SequenceSettings(**settings)))


def assert_same_pairs(pairs):
    assert len(pairs) == NUM_PAIRS
    for pair, (left, right) in zip(pairs, image_pairs(), strict=True):
        np.testing.assert_array_equal(pair.left if pair.left.ndim == 2 else pair.left[..., 0], left)
        np.testing.assert_array_equal(
            pair.right if pair.right.ndim == 2 else pair.right[..., 0], right
        )


def positions(path, **settings):
    return [pair.T_world_left[2, 3] for pair in read(path, **settings)]
