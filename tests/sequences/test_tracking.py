"""Tracked points look alike in both pairs, unless both show only noise there."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from recon.records import StereoPair
from recon.sequences.odometry.tracking import likeness, track
from tests.sequences.drives import RIG

SIZE, DISPARITY_PX = 256, 8
SMALL = replace(RIG, width=SIZE, height=SIZE)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def taken(rng, scene):
    """A pair that shows a wide scene with new noise."""
    noisy = [
        np.clip(np.rint(image + rng.normal(0.0, 2.0, image.shape)), 0, 255).astype(np.uint8)
        for image in (scene[:, DISPARITY_PX:], scene[:, :-DISPARITY_PX])
    ]
    return StereoPair(left=noisy[0], right=noisy[1], rig=SMALL)


def likenesses(rng, scene):
    first, second = taken(rng, scene), taken(rng, scene)
    return likeness(first, second, track(first, second, np.eye(4)))


def test_texture_is_alike(rng):
    scene = cv2.GaussianBlur(rng.normal(0.0, 80.0, (SIZE, SIZE + DISPARITY_PX)), (0, 0), 2.0)
    found = likenesses(rng, 128.0 + scene)
    assert len(found) > 100
    assert np.quantile(found, 0.05) > 0.8


def test_noise_is_tracked_where_it_was_guessed_but_is_not_alike(rng):
    found = likenesses(rng, np.full((SIZE, SIZE + DISPARITY_PX), 128.0))
    assert len(found) > 20
    assert found.max() < 0.4


def test_tracks_along_the_horizon_are_not_alike(rng):
    """They would slide to where they were guessed, and agree with any motion."""
    scene = np.repeat([200.0, 100.0], SIZE // 2)[:, None] + np.zeros(SIZE + DISPARITY_PX)
    first, second = taken(rng, scene), taken(rng, scene)
    tracks = track(first, second, np.eye(4))
    is_level = np.abs(tracks.first.points_px[:, 1] - SIZE / 2) < 4.0
    assert np.count_nonzero(is_level) > 5
    assert likeness(first, second, tracks)[is_level].max() < 0.4
