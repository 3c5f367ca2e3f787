"""Outlines are placed to small shares of a pixel by the colours of the pixels that they cross."""

import numpy as np
import pytest

from recon.geometry import pose, rotation_about_y
from recon.localisation.look import Look
from recon.localisation.portrait import Portrait
from tests.localisation.trees import taken, tree

PAIR = taken(30)
STEPS_PX = np.arange(-1.0, 1.01, 0.1)


@pytest.fixture(scope="module")
def portrait():
    return Portrait.of((tree(),), [taken(degrees) for degrees in range(0, 360, 60)], 1.0)


def by_heading(portrait, paint, block):
    T = PAIR.T_world_left
    poses = [
        pose(rotation_about_y(step / PAIR.rig.focal_px) @ T[:3, :3], T[:3, 3]) for step in STEPS_PX
    ]
    return Look(pair=PAIR).values(portrait.solids, paint, poses, block)


@pytest.mark.parametrize("block", [1, 2])
def test_the_true_heading_is_the_likeliest_by_outlines_alone(portrait, block):
    value = by_heading(portrait, portrait.plain, block)
    assert abs(STEPS_PX[value.argmax()]) < 0.15


def test_a_tenth_of_a_pixel_changes_the_likelihood(portrait):
    value = by_heading(portrait, portrait.plain, 1)
    middle = len(value) // 2
    assert value[middle] - max(value[middle - 3], value[middle + 3]) > 10.0


def test_an_image_is_as_likely_alone_as_among_others(portrait):
    poses = [taken(degrees).T_world_left for degrees in (30, 90, 35)]
    look = Look(pair=PAIR)
    together = look.values(portrait.solids, portrait.paint, poses, 1)
    alone = [look.values(portrait.solids, portrait.paint, [one], 1)[0] for one in poses]
    assert together == pytest.approx(alone, rel=1e-9)
    _, here = look.densities(portrait.solids, portrait.paint, poses[0], 1)
    assert here.sum() == pytest.approx(alone[0], rel=1e-9)
