"""A pair that sees one round tree is located by drawing the tree as it would be seen."""

from dataclasses import replace

import numpy as np
import pytest

from recon.localisation.cameras import camera_of
from recon.localisation.drawing import draw, texels
from recon.localisation.keeper import PlaceKeeper
from recon.localisation.look import Look
from recon.localisation.portrait import Portrait
from recon.localisation.recall import KnownWorld
from recon.localisation.revolved import revolved
from recon.mapping.mapper import Mapper
from recon.records import Box, Cone, Cylinder, Ellipsoid, Part, Sphere, StereoPair, TruncatedCone
from recon.settings import Settings, explorers, updated
from tests.localisation.trees import off, taken, tree, turned

SETTINGS = updated(explorers(Settings()), {"map": {"min_count": 3}})
SIDES = range(0, 360, 60)
UP = np.array([0.0, 1.0, 0.0])
AHEAD = np.array([0.5, 0.3, 12.0])


@pytest.fixture(scope="module")
def known():
    """A map of one tree, taken from six sides."""
    mapper, keeper = Mapper(SETTINGS, compares=False), PlaceKeeper()
    for number, degrees in enumerate(SIDES):
        pair = replace(taken(degrees), stamp_s=float(number))
        (step,) = mapper.process(pair)
        keeper.add(pair, step.number)
    return KnownWorld.of(mapper.voxels(), keeper.atlas(mapper.trajectory), SETTINGS, (tree(),))


@pytest.fixture(scope="module")
def portrait():
    return Portrait.of((tree(),), [taken(degrees) for degrees in SIDES], 1.0)


def portrait_of(*solids):
    parts = [Part(role="x", solid=one, hue_deg=None, num_voxels=9, rms=0.1) for one in solids]
    return Portrait.of((replace(tree(), parts=tuple(parts)),), [], 1.0)


@pytest.mark.parametrize(
    "solid",
    [
        Sphere(centre=AHEAD, radius=2.0),
        Ellipsoid(centre=AHEAD, radii=np.array([3.0, 2.0, 2.0]), axes=np.eye(3)),
        Cylinder(point=AHEAD - UP, axis=UP, radius=2.0, height=3.0),
        TruncatedCone(point=AHEAD - UP, axis=UP, radius_bottom=3.0, radius_top=1.0, height=3.0),
        Cone(apex=AHEAD + 2.0 * UP, axis=-UP, half_angle_rad=0.7, height=3.0),
    ],
)
def test_what_is_drawn_lies_on_the_solid(solid):
    rig, drawn_of = taken(0).rig, portrait_of(solid).solids
    drawn = draw(drawn_of, camera_of(np.eye(4), rig), 1)
    v, u = np.nonzero(drawn.solid >= 0)
    points = rig.rays(np.column_stack([u, v]).astype(np.float64)) * drawn.depth[v, u, None]
    assert len(points) > 500
    assert solid.distances(points).max() < 1e-6
    number = texels(drawn_of, drawn, camera_of(np.eye(4), rig))
    assert number.max() < drawn_of.shape.prod(axis=1).sum()
    assert ((number < 0) == np.isinf(drawn.depth)).all()


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_solids_are_drawn_alike_in_any_unit(scale):
    ball = Sphere(centre=AHEAD, radius=2.0)
    scaled = Sphere(centre=scale * AHEAD, radius=scale * 2.0)
    camera = camera_of(np.eye(4), taken(0).rig)
    here, there = revolved([ball], 0.5), revolved([scaled], scale * 0.5)
    one, other = draw(here, camera, 1), draw(there, camera, 1)
    assert (one.solid >= 0).sum() > 500
    np.testing.assert_array_equal(texels(there, other, camera), texels(here, one, camera))
    np.testing.assert_allclose(other.depth, scale * one.depth)


def test_portrait_of_a_box_is_none():
    assert portrait_of(Box(centre=AHEAD, axes=np.eye(3), sizes=np.ones(3))) is None


def test_portrait_is_whole_only_if_every_part_is_drawn(portrait):
    box = Box(centre=AHEAD, axes=np.eye(3), sizes=np.ones(3))
    assert portrait.is_whole
    ball = Sphere(centre=AHEAD, radius=2.0)
    assert not portrait_of(ball, box).is_whole
    far = replace(ball, radius=10.0 * tree().size.max())
    assert not portrait_of(ball, far).is_whole
    assert portrait_of(far) is None


def test_the_true_side_is_the_likeliest(portrait):
    pair = taken(30)
    poses = [turned(pair.T_world_left, degrees) for degrees in range(0, 360, 10)]
    value = Look(pair=pair).values(portrait.solids, portrait.paint, poses, 2)
    assert value.argmax() == 0
    assert value[0] - value[1:].max() > 1000.0


def test_all_sides_are_alike_without_texture(portrait):
    pair = taken(30)
    poses = [turned(pair.T_world_left, degrees) for degrees in range(0, 360, 10)]
    value = Look(pair=pair).values(portrait.solids, portrait.plain, poses, 2)
    assert np.ptp(value) < 300.0


def test_a_pose_inside_a_solid_is_impossible(portrait):
    inside = taken(30).T_world_left.copy()
    inside[:3, 3] = tree().centre * [1.0, 0.5, 1.0]
    value = Look(pair=taken(30)).values(portrait.solids, portrait.paint, [inside], 4)
    assert value[0] == -np.inf


def test_pair_beside_a_lone_tree_is_located(known):
    pair = taken(30)
    found = known.painted([taken(degrees) for degrees in SIDES]).recall(pair)
    assert found
    assert off(found.T_world_left, pair) < min(0.3, 4.0 * found.sigma)
    assert found.T_world_left[:3, 2] @ pair.T_world_left[:3, 2] > np.cos(np.radians(2.0))
    assert found.inlier_share > 0.7


def test_texture_that_repeats_does_not_locate_a_pair(known):
    # The same images on opposite sides, as of a texture that goes twice around.
    twice = [replace(taken(n % 180), T_world_left=taken(n).T_world_left) for n in SIDES]
    found = known.painted(twice).recall(taken(30))
    assert found.reason == "several places look like it"


def test_image_of_something_else_is_not_located(known):
    pair = taken(30)
    other = StereoPair(left=255 - pair.left, right=255 - pair.right, rig=pair.rig)
    assert not known.painted([taken(degrees) for degrees in SIDES]).recall(other)


def test_lone_tree_without_texture_is_ambiguous(known):
    assert not known.recall(taken(30))
