"""Doubts: places that are viewed again before the agent ends."""

from dataclasses import replace

import numpy as np
import pytest

from recon.exploration import world_model
from recon.exploration.doubts import CLOSE, hiding_places
from recon.exploration.floor import Floor
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
