"""Auto focus: the second view targets the nearest object, and searches around it."""

import numpy as np
import pytest

from recon.exploration.focus import focusable, focusing, range_of
from recon.records import View
from recon.settings import Settings, explorers, updated
from recon.world.world import World

FOCUSED = updated(explorers(Settings()), {"eyes": {"auto_focus": True}})


def looking(at, distance):
    ahead = np.array([at[0], 0.0, at[1]])
    return View(
        position=np.array([0.0, 5.0, 0.0]),
        target=np.array([0.0, 5.0, 0.0]) + distance * ahead / np.linalg.norm(ahead),
    )


def test_second_view_is_focused_on_the_nearest_object():
    world, taken = World.from_file("village", FOCUSED), []

    def take(view):
        taken.append(view)
        return world.take(view)

    pair = focusing(take, FOCUSED)(looking((20.0, -5.0), 60.0))
    distance = np.linalg.norm(taken[1].target - taken[1].position)
    assert len(taken) == 2
    assert 12.0 < distance < 16.0
    low, high = pair.disparity_range
    near = float(pair.rig.disparity(13.6))
    assert low < pair.rig.disparity_offset_px
    assert near < high < near + 5


def test_first_view_is_kept_if_nothing_is_seen():
    world = World.from_file("village", FOCUSED)
    pair = focusing(world.take, FOCUSED)(looking((-1.0, 0.0), 20.0))
    sky = looking((1.0, 1.0), 20.0)
    up = View(position=sky.position, target=sky.position + np.array([1.0, 30.0, 1.0]))
    nothing = focusing(world.take, FOCUSED)(up)
    assert nothing.disparity_range == (-10, 20)
    assert pair.rig.baseline == nothing.rig.baseline


def test_views_are_unchanged_without_auto_focus():
    settings = explorers(Settings())
    take = object()
    assert focusing(take, settings) is take
    assert focusable(settings) is settings
    open_range = focusable(FOCUSED).matching.searching((-3, 4))
    assert (open_range.min_disparity, open_range.max_disparity) == (-3, 4)
    assert focusable(FOCUSED).matching.cross_check == FOCUSED.matching.cross_check


@pytest.mark.parametrize("distance", [3.0, 12.0, 60.0])
def test_search_range_covers_infinity_and_slightly_nearer_points(distance):
    rig = World.from_file("village", FOCUSED).take(looking((1.0, 0.0), distance)).rig
    low, high = range_of(rig, distance)
    assert low <= rig.disparity_offset_px - 0.9
    assert high >= rig.disparity(distance / 1.5)
    assert high - low < 50.0 / distance * 2 + 8
