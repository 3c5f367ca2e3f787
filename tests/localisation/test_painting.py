"""The texture of a solid is read from the images that show it best, at any distance."""

import numpy as np
import pytest

from recon.localisation.cameras import camera_of
from recon.localisation.drawing import draw, viewed
from recon.localisation.paint import painted
from recon.localisation.portrait import Portrait
from recon.records import View, as_rgb
from tests.localisation.trees import AWAY, taken, tree, world

SIDES = range(0, 360, 40)


@pytest.fixture(scope="module")
def portrait():
    return Portrait.of((tree(),), [taken(degrees) for degrees in SIDES], 1.0)


def off(portrait, pair):
    """Differences of colours where a solid is seen and not at its outline."""
    camera = camera_of(pair.T_world_left, pair.rig)
    solids, drawn = portrait.solids, draw(portrait.solids, camera, 1)
    views, found = viewed(solids, camera), []
    for row, column in np.argwhere(drawn.solid >= 0).tolist():
        s = drawn.solid[row, column]
        around = drawn.solid[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        if (around == s).all():
            x = (column - camera.cx_px) / camera.focal_px
            y = (row - camera.cy_px) / camera.focal_px
            ray, colour = (x, y, 1.0 / camera.focal_px), np.zeros(3)
            painted(solids, views, s, portrait.paint, ray, drawn.depth[row, column], colour)
            found.append(as_rgb(pair.left)[row, column] - colour)
    return np.array(found)


def test_a_side_between_those_of_the_run_is_painted_as_it_is(portrait):
    pair = taken(20)
    contrast = as_rgb(pair.left).reshape(-1, 3).std(axis=0).mean()
    assert np.median(np.abs(off(portrait, pair))) < min(8.0, 0.3 * contrast)


def test_it_has_the_colours_of_what_is_seen_from_twice_as_far(portrait):
    angle, middle = np.radians(20), tree().centre * [1.0, 0.0, 1.0] + [0.0, 5.0, 0.0]
    place = middle + 2.0 * AWAY * np.array([np.cos(angle), 0.0, np.sin(angle)])
    far = world().take(View(position=place, target=middle))
    assert np.median(np.abs(off(portrait, far))) < 8.0
