"""Random worlds keep distances, vary in looks, and follow from their seed."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.settings.settings import Settings
from recon.world.generator import START_ROOM, random_scene
from recon.world.scene import read_scene, write_scene
from recon.world.world import World


def world_with(seed, num_objects, gap):
    settings = Settings()
    scene = random_scene(np.random.default_rng(seed), num_objects, gap)
    return World(scene, settings.eyes, settings.render, settings.world)


@pytest.mark.parametrize(("num_objects", "gap"), [(3, 22.0), (12, 22.0), (12, 4.0), (30, 4.0)])
def test_objects_keep_their_distance_to_each_other_and_to_the_start(num_objects, gap):
    world = world_with(1, num_objects, gap)
    assert len(world.objects) == num_objects
    middles = np.array([found.centre[[0, 2]] for found in world.objects])
    radii = np.array([found.size[0] / 2 for found in world.objects])
    between = np.hypot(*(middles[:, None] - middles[None]).T) - radii - radii[:, None]
    nearest = between[~np.eye(num_objects, dtype=bool)].min()
    assert gap - 0.01 < nearest < 4 * gap + 40
    assert (np.abs(middles).max(axis=1) + radii).max() <= 100 - gap + 0.01
    assert (np.hypot(*middles.T) - radii).min() > START_ROOM - 0.01
    assert max(found.size[1] for found in world.objects) <= world.floor.height


def test_all_three_kinds_occur_in_many_sizes():
    objects = [found for seed in range(4) for found in world_with(seed, 12, 8.0).objects]
    labels = [found.label for found in objects]
    assert set(labels) == {"apple tree", "pine tree", "cottage"}
    assert min(labels.count(label) for label in set(labels)) >= 8
    widths = np.array([found.size[0] for found in objects])
    assert widths.min() < 8 < 14 < widths.max()


def test_world_follows_from_its_seed_and_round_trips_through_its_file(tmp_path):
    first, second, other = (random_scene(np.random.default_rng(seed), 6, 8.0) for seed in (5, 5, 6))
    assert first == second != other
    write_scene(first, tmp_path / "random.scene")
    again = read_scene(tmp_path / "random.scene")
    assert (again.visuals, again.textures) == (first.visuals, first.textures)


@pytest.mark.parametrize(("num_objects", "gap"), [(200, 22.0), (1, 200.0)])
def test_too_many_or_too_distant_objects_are_rejected(num_objects, gap):
    with pytest.raises(InputError, match=rf"num_objects is {num_objects} and gap is {gap}, but on"):
        random_scene(np.random.default_rng(0), num_objects, gap)
