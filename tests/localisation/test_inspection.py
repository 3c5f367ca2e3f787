"""A pair that sees one round tree is located by the tree's texture."""

from dataclasses import replace

import numpy as np
import pytest

from recon.localisation.keeper import PlaceKeeper
from recon.localisation.recall import KnownWorld
from recon.mapping.mapper import Mapper
from recon.runs.door import explorers
from recon.settings import Settings, updated
from tests.localisation.trees import off, taken, tree

SETTINGS = updated(explorers(Settings()), {"map": {"min_count": 3}})
SIDES = range(0, 360, 60)


@pytest.fixture(scope="module")
def known():
    """A map of one tree, taken from six sides."""
    mapper, keeper = Mapper(SETTINGS, compares=False), PlaceKeeper()
    for number, degrees in enumerate(SIDES):
        pair = replace(taken(degrees), stamp_s=float(number))
        (step,) = mapper.process(pair)
        keeper.add(pair, step.number)
    return KnownWorld.of(mapper.voxels(), keeper.atlas(mapper.trajectory), SETTINGS, (tree(),))


def test_pair_beside_a_lone_tree_is_located_by_texture(known):
    pair = taken(30)
    found = known.textured([taken(degrees) for degrees in SIDES]).recall(pair)
    assert found
    assert off(found.T_world_left, pair) < min(0.3, 4.0 * found.sigma)
    assert found.T_world_left[:3, 2] @ pair.T_world_left[:3, 2] > np.cos(np.radians(2.0))


def test_texture_that_repeats_does_not_locate_a_pair(known):
    # The same images on opposite sides, as of a texture that goes twice around.
    twice = [replace(taken(n % 180), T_world_left=taken(n).T_world_left) for n in SIDES]
    found = known.textured(twice).recall(taken(30))
    assert found.reason == "several places look like it"


def test_lone_tree_without_texture_is_ambiguous(known):
    assert not known.recall(taken(30))
