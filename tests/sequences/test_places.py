"""Blobs are found where they are."""

import numpy as np
import pytest

from recon.sequences.odometry.places import STRETCHES, blobs

SIZE, REACH_PX = 200, 3.0


def drawn(middles, radius):
    """An image with round blobs, pixel (0, 0) at the centre of the top-left one."""
    rows, columns = np.indices((SIZE, SIZE))
    image = np.full((SIZE, SIZE), 60.0)
    for u, v in middles:
        image += 150.0 * np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / (2.0 * radius**2))
    return np.round(image).astype(np.uint8)


@pytest.mark.parametrize("radius", [2.0, 4.0])
@pytest.mark.parametrize("stretch", STRETCHES)
def test_blobs_are_found_where_they_are(radius, stretch):
    """A share of a pixel to one side turns and shifts what comes nearer or goes away."""
    grid = np.arange(25.0, 190.0, 30.0)
    middles = np.stack(np.meshgrid(grid, grid), axis=2).reshape(-1, 2)
    middles += np.random.default_rng(3).uniform(-0.5, 0.5, middles.shape)
    points, _ = blobs(drawn(middles, radius), stretch)
    off = points[:, None] - middles
    nearest = np.take_along_axis(off, np.hypot(*off.T).T.argmin(axis=1)[:, None, None], axis=1)
    found = nearest[np.hypot(*nearest[:, 0].T) < REACH_PX, 0]
    assert len(found) > 20
    assert np.abs(np.median(found, axis=0)).max() < 0.1
