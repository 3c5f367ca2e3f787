"""A round tree of a simulated world, and pairs that see it from all sides."""

from functools import cache

import numpy as np

from recon.geometry import pose, rotation_about_y
from recon.records import Cylinder, FoundObject, Part, Sphere, View
from recon.settings import Settings, explorers
from recon.world.world import World

AWAY = 14.0


@cache
def world():
    return World.from_file("three_apples", explorers(Settings()))


@cache
def tree():
    """One of the trees, as the world has it."""
    one = world().objects[0]
    x, _, z = one.centre
    radius = one.size[0] / 2.0
    trunk = Cylinder(
        point=np.array([x, 0.0, z]), axis=np.array([0.0, 1.0, 0.0]), radius=radius / 2.0,
        height=2.0 * radius,
    )  # fmt: skip
    crown = Sphere(centre=np.array([x, one.size[1] - radius, z]), radius=radius)
    parts = [
        Part(role=role, solid=solid, hue_deg=None, num_voxels=50, rms=0.1)
        for role, solid in (("trunk", trunk), ("crown", crown))
    ]
    return FoundObject(
        id=0, label="apple tree", probability=0.9, centre=one.centre, size=one.size,
        num_voxels=100, parts=tuple(parts),
    )  # fmt: skip


@cache
def taken(degrees):
    """A pair from one side of the tree, at the height of the eyes."""
    x, _, z = tree().centre
    angle, middle = np.radians(degrees), np.array([x, 5.0, z])
    place = middle + AWAY * np.array([np.cos(angle), 0.0, np.sin(angle)])
    return world().take(View(position=place, target=middle))


def turned(T_world_left, degrees):
    turn = rotation_about_y(np.radians(degrees))
    middle = tree().centre * [1.0, 0.0, 1.0]
    return pose(turn, middle - turn @ middle) @ T_world_left


def off(T_world_left, pair):
    return np.linalg.norm(T_world_left[:3, 3] - pair.T_world_left[:3, 3])
