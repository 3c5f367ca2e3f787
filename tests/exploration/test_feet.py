"""Feet of obstacles in the image, for surfaces without matches."""

import dataclasses

import numpy as np
import pytest

from recon.exploration.feet import foot_distances
from recon.exploration.floor import Floor
from recon.records import View
from recon.settings import Settings, updated
from recon.world.generator import plain_ground
from recon.world.visuals import PolygonVisual, Scene, Vertex
from recon.world.world import World

PLACE = np.zeros(2)
AHEAD = np.radians(-90.0)
FAR = 100.0


def wall(z, half=10.0):
    """Make a wall of one colour, whose horizontal edges give no matches."""
    corners = ((-half, 0.0), (half, 0.0), (half, 7.0), (-half, 7.0))
    return PolygonVisual(
        cull_back=False,
        vertices=tuple(
            Vertex(position=(x, y, z), colour=(0.5, 0.3, 0.3, 1), uv=(0, 0)) for x, y in corners
        ),
    )


def tiled_ground(texture):
    ground = plain_ground()
    vertices = tuple(
        dataclasses.replace(v, uv=(v.position[0] / 16, v.position[2] / 16), colour=(1, 1, 1, 1))
        for v in ground.vertices
    )
    return dataclasses.replace(ground, vertices=vertices, texture=texture)


def feet_of(*visuals, azimuths_deg=(-90.0,), textures=(), **render):
    settings = updated(Settings(), {"render": render})
    scene = Scene(visuals=visuals, textures=textures)
    world = World(scene, settings.eyes, settings.render, settings.world)
    pair = world.take(View(position=np.array([0.0, 5, 0]), target=np.array([0.0, 5, -20.0])))
    floor = Floor(size_x=120, size_z=120)
    return foot_distances(pair, np.radians(azimuths_deg), PLACE, (0.0, FAR), floor)


@pytest.mark.parametrize("noise", [0.0, 5.0])
@pytest.mark.parametrize("distance", [12.0, 30.0])
def test_uniform_wall_is_located_at_its_foot(distance, noise):
    foot = feet_of(wall(-distance), plain_ground(), noise=noise)
    assert foot == pytest.approx([distance], abs=0.1 * distance)


@pytest.mark.parametrize("noise", [0.0, 2.0, 10.0])
def test_open_ground_has_no_foot(noise):
    feet = feet_of(plain_ground(), azimuths_deg=np.linspace(-125, -55, 100), noise=noise)
    assert np.isinf(feet).mean() >= 0.99


def test_ground_continues_beside_a_wall():
    feet = feet_of(wall(-20.0, half=4.0), plain_ground(), azimuths_deg=(-90.0, -60.0, -120.0))
    assert np.isfinite(feet).tolist() == [True, False, False]


def test_textured_ground_gives_no_feet():
    feet = feet_of(tiled_ground(0), azimuths_deg=np.linspace(-125, -55, 50), textures=("leaves",))
    assert np.isinf(feet).mean() > 0.5


def test_foot_blocks_a_cell_until_a_nearer_view_sees_it_free():
    floor = Floor(size_x=120, size_z=120)
    cell = tuple(floor.cells([0.0, -20.0]))
    rays = floor.azimuths(AHEAD, np.radians(80.0), 60.0)
    floor.see(PLACE, rays, np.full(len(rays), 60.0))
    assert floor.known_free[cell]
    floor.bar(PLACE, np.array([AHEAD]), np.array([20.0]))
    assert floor.barred[cell]
    assert not floor.known_free[cell]
    assert floor.barred.sum() == 1
    floor.see(np.array([0.0, -10.0]), rays, np.full(len(rays), 30.0))
    assert floor.known_free[cell]
    floor.bar(np.array([0.0, -15.0]), np.array([AHEAD, 0.0]), np.array([5.0, np.inf]))
    assert not floor.known_free[cell]
