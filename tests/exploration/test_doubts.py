"""Doubts: places that are viewed again before the agent ends."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from recon.exploration import world_model
from recon.exploration.doubts import (
    CLOSE,
    cut_off,
    elsewhere,
    hiding_places,
    seen_from_afar,
    strange,
)
from recon.exploration.floor import Floor
from recon.exploration.obstacles import Obstacle
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.records import UNKNOWN
from recon.settings import Settings


def floor_with_pocket(size, feet):
    """Make ground seen from 20 units, except for a square with feet on its edge."""
    floor = Floor(size_x=60.0, size_z=60.0)
    floor.seen_from[:] = 20.0
    floor.seen_from[30 : 30 + size, 20 : 20 + size] = np.inf
    floor.barred_from[30, 20 : 20 + feet] = 15.0
    return floor


def test_unseen_ground_behind_a_foot_may_hide_an_object():
    (found,) = hiding_places(floor_with_pocket(size=7, feet=3), (), 2.0)
    assert np.allclose(found.centre, [3.5, -6.5])
    assert 4.0 < found.radius < 4.5


@pytest.mark.parametrize(("size", "feet"), [(7, 0), (4, 3), (0, 20)])
def test_ground_without_a_foot_or_space_hides_no_object(size, feet):
    assert not list(hiding_places(floor_with_pocket(size, feet), (), 2.0))


def test_legs_of_a_table_far_away_hide_one_object():
    floor = floor_with_pocket(size=0, feet=0)
    for x in (30, 34, 38):
        for z in (20, 24):
            floor.barred_from[x : x + 2, z : z + 2] = 50.0
            floor.seen_from[x : x + 2, z : z + 2] = 55.0
    (found,) = hiding_places(floor, (), 2.0)
    assert np.allclose(found.centre, [5.0, -7.0])
    floor.seen_from[:] = 20.0
    assert not list(hiding_places(floor, (), 2.0))


REFUTED = Detection(centre=np.zeros(2), radius=1.0, distance=50.0, sigma=4.0, azimuth_rad=0.0)


def place_left(seen_to, obstacles=()):
    """Where a detection may still be if all ground up to an x was seen from 20 units."""
    floor = Floor(size_x=60.0, size_z=60.0)
    floor.seen_from[: seen_to + 30] = 20.0
    scales = Scales.of(Settings())
    state = SimpleNamespace(floor=floor, obstacles=obstacles, refuted=[REFUTED], scales=scales)
    return list(elsewhere(state))


def test_detection_may_be_where_no_closer_view_saw_the_ground():
    assert REFUTED.is_refuted(Floor(size_x=60.0, size_z=60.0)) is False
    (found,) = place_left(seen_to=7)
    assert np.allclose(found.centre, [12.0, 0.0])
    assert found.radius == 5.0
    assert place_left(seen_to=30) == []


def test_detection_in_the_direction_of_an_obstacle_is_that_obstacle():
    near, beside = (SimpleNamespace(centre=np.array([-8.0, z]), radius=2.0) for z in (0.0, 9.0))
    assert place_left(seen_to=7, obstacles=(near,)) == []
    assert len(place_left(seen_to=7, obstacles=(beside,))) == 1


@pytest.fixture
def resembling(monkeypatch):
    """Let no object have a sure name; all resemble a kind with some probability."""
    recognise = world_model.recognise

    def let(chance):
        def doubting(voxels, settings):
            found = recognise(voxels, settings)
            name = {"label": UNKNOWN, "probability": 1 - chance, "nearest": (("cottage", chance),)}
            return replace(found, objects=tuple(replace(one, **name) for one in found.objects))

        monkeypatch.setattr(world_model, "recognise", doubting)

    return let


AROUND = np.radians([0.0, 90.0, 180.0, 270.0])
STRANGE = SimpleNamespace(label=UNKNOWN, probability=1.0, nearest=())
RESEMBLING = SimpleNamespace(label=UNKNOWN, probability=0.6, nearest=(("tree", 0.4),))
TREE = SimpleNamespace(label="tree", probability=0.95, nearest=(("tree", 0.95),))


def obstacle(found, is_whole=(True,) * 4, **more):
    """Make an obstacle seen from four sides."""
    return Obstacle(
        cells=np.empty((0, 2), np.intp), covered=np.empty((0, 2), np.intp), centre=np.ones(2),
        radius=3.0, top=9.0, voxels=None, bearings_rad=AROUND, away=np.array([9.0, 11, 14, 9]),
        is_whole=np.array(is_whole), found=found, **more,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("found", "is_whole", "number"),
    [
        (STRANGE, [False] * 4, 1),
        (STRANGE, [True, True, False, False], 1),
        (STRANGE, [True, True, True, False], 0),
        (RESEMBLING, [False] * 4, 0),
        (TREE, [False] * 4, 0),
        (None, [False] * 4, 0),
    ],
)
def test_tops_of_strange_things_are_viewed_from_half_of_all_directions(found, is_whole, number):
    again = cut_off([obstacle(found, is_whole)])
    assert len(again) == number
    for one in again:
        assert one.bearings_rad.tolist() == AROUND[is_whole].tolist()


@pytest.mark.parametrize(
    ("others", "number"),
    [([TREE, TREE], 1), ([TREE], 1), ([], 0), ([TREE, TREE, STRANGE], 2), ([None], 0)],
)
def test_strange_things_are_looked_at_once_where_most_have_names(others, number):
    known = [obstacle(found) for found in (STRANGE, *others)]
    looks = strange(known)
    assert len(looks) == number
    assert all(one.sigma == np.inf for one in looks)
    assert len(seen_from_afar(known, 10.0)) == number


@pytest.mark.parametrize(("num_before", "sigma"), [(100, np.inf), (95, np.inf), (85, 0.0)])
def test_strange_thing_is_looked_at_from_all_sides_while_looks_show_more(num_before, sigma):
    (look,) = strange([obstacle(STRANGE, num_named=100, num_before=num_before), obstacle(TREE)])
    assert look.sigma == sigma


def test_side_of_a_strange_thing_that_was_seen_from_afar_counts_as_unseen():
    (again,) = seen_from_afar([obstacle(STRANGE), obstacle(TREE)], 10.0)
    assert again.bearings_rad.tolist() == AROUND[[0, 1, 3]].tolist()


def close_views(done, disc):
    """Numbers of the views aimed at a disc from half the usual distance.

    The map makes the disc up to two cells wider, and the distance is from there.
    """
    x, z, radius, _ = disc
    for number, view in enumerate(done.views):
        apart = np.hypot(*(view.position[[0, 2]] - (x, z))) - radius
        is_close = apart <= CLOSE * Settings().exploration.clearance + 2.0
        if is_close and np.allclose(view.target[[0, 2]], (x, z), atol=1.0):
            yield number


def test_doubtful_object_is_viewed_from_nearby_before_the_end(explore_discs, resembling):
    disc, near = (20.0, 5.0, 4.0, 12.0), []
    for chance in (0.02, 0.4):
        resembling(chance)
        done = explore_discs([disc], observe=lambda step: None)
        assert done.stop_reason == "all known"
        near.append(len(list(close_views(done, disc))))
    assert near[0] + 1 <= near[1] <= near[0] + 3


def test_doubtful_object_is_viewed_again_before_the_agent_goes_on(explore_discs, resembling):
    discs = [(20.0, 5.0, 4.0, 12.0), (-35.0, -5.0, 4.0, 12.0)]
    resembling(0.4)
    done = explore_discs(discs, observe=lambda step: None)
    first, second = sorted(list(close_views(done, disc)) for disc in discs)
    assert max(first) < min(second)
