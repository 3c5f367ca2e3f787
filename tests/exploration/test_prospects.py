"""Rounds over ground not yet seen, and the views that show the way."""

import numpy as np
import pytest

from recon.exploration.floor import Floor
from recon.exploration.gains import Visibility
from recon.exploration.paths import unexplored
from recon.exploration.prospects import Prospects
from recon.exploration.scan import Detection
from recon.exploration.search import Search
from recon.exploration.sides import Sides
from recon.exploration.state import State
from recon.records import View
from recon.settings import Settings

FIELD = np.radians(80.0)
REACH = 20.0
TREE = Detection(centre=np.array([60.0, 0.0]), radius=3.0, distance=60.0, sigma=1.0)


@pytest.fixture
def floor():
    """All ground is seen, but for that around the tree."""
    floor = Floor(size_x=160, size_z=160)
    floor.seen_from[~floor.disc(TREE.centre, 35.0)] = 10.0
    return floor


def state_on(floor):
    return State(
        num_pairs=1,
        view=View(position=np.array([0.0, 5.0, 0.0]), target=np.array([0.0, 5.0, -10.0])),
        pair=None,
        voxel_map=None,
        floor=floor,
        obstacles=(),
        detections=(TREE,),
        refuted=(),
        sure_range=REACH,
        objects=(),
        simulator=None,
        settings=Settings(),
    )


def next_stop(floor, taken=()):
    """Prospects, and the position and azimuth of the next view."""
    state = state_on(floor)
    unknown = unexplored(floor, ())
    search = Search(wanted=(TREE,), clearance=10.0, reach=REACH)
    prospects = Prospects.of(state, unknown, (TREE,), search)
    visibility = Visibility.over(floor, prospects.places, FIELD, 90.0, unknown)
    visibility = visibility.without(taken, state.scales.same_place)
    sides = Sides.of((TREE,), prospects.places, floor, FIELD, search)
    stop = prospects.first_stop(visibility, sides, unknown, state.scales)
    return prospects, None if stop is None else (prospects.places[stop[0]], stop[1])


def towards_the_tree(place):
    x, z = TREE.centre - place
    return np.arctan2(z, x)


def test_places_beyond_unseen_ground_are_hoped_for(floor):
    prospects, _ = next_stop(floor)
    beyond = prospects.places[~prospects.reached]
    assert len(beyond) > 8
    assert np.all(np.hypot(*(beyond - TREE.centre).T) <= 17.1)
    assert prospects.known.reaches(prospects.places[prospects.reached]).all()
    assert prospects.hoped.reaches(beyond).all()


def test_way_to_an_obstacle_beyond_unseen_ground_is_looked_at_first(floor):
    _, (place, azimuth) = next_stop(floor)
    assert np.hypot(*(place - TREE.centre)) > 35.0
    assert np.cos(azimuth - towards_the_tree(place)) > np.cos(FIELD / 2.0)


def test_reached_place_is_gone_to_without_a_look_at_the_way(floor):
    floor.seen_from[:] = 10.0
    _, (place, azimuth) = next_stop(floor)
    assert np.hypot(*(place - TREE.centre)) < REACH + TREE.radius
    assert np.cos(azimuth - towards_the_tree(place)) > np.cos(FIELD / 2.0)


def test_places_beyond_a_way_looked_at_in_vain_are_given_up(floor):
    places = floor.centres(np.argwhere(floor.known_free))
    near = places[np.hypot(*(places - TREE.centre).T) < 120.0][::3]
    azimuths = np.radians(np.arange(0.0, 360.0, 15.0))
    _, stop = next_stop(floor, [(place, azimuth) for place in near for azimuth in azimuths])
    assert stop is None
