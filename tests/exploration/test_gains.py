"""What views would add, and rounds of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.exploration.floor import Floor
from recon.exploration.frontier import widest_gap
from recon.exploration.gains import NUM_RAYS, Candidates, Visibility, new_sides, ray_of
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.exploration.tour import first_stop, insertion
from recon.settings import Settings

FIELD = np.radians(80.0)
SCALES = Scales.of(Settings())


@pytest.fixture
def floor():
    return Floor(size_x=120, size_z=120)


def visibility_from(floor, *places, reach=40.0):
    return Visibility.over(floor, np.array(places, dtype=np.float64), FIELD, reach)


def test_a_view_of_unknown_ground_shows_its_field(floor):
    area = visibility_from(floor, (0.0, 0.0)).area(~floor.occupied)
    assert area.shape == (1, NUM_RAYS)
    assert area == pytest.approx(0.5 * FIELD * 40.0**2, rel=0.06)


def test_a_thing_and_the_border_hide_ground(floor):
    floor.occupied |= floor.disc(np.array([15.0, 0.0]), 4.0)
    area = visibility_from(floor, (0.0, 0.0), (55.0, 0.0)).area(~floor.occupied)
    east, west = ray_of(np.array([0.0, np.pi]))
    assert 0.4 * area[0, west] < area[0, east] < 0.8 * area[0, west]
    assert area[1, east] < 0.2 * area[1, west]


def test_a_view_that_was_taken_shows_nothing_more(floor):
    visibility = visibility_from(floor, (0.0, 0.0), (20.0, 0.0)).without([(np.zeros(2), 0.0)], 3.0)
    area = visibility.area(~floor.occupied)
    assert area[0, ray_of(np.array([0.2]))[0]] == 0.0
    assert area[0, ray_of(np.array([0.5]))[0]] > 0.0
    assert area[1, 0] > 0.0


def views_of_the_middle(*places):
    places = np.array(places, dtype=np.float64)
    return Candidates(places=places, targets=np.tile([0.0, 5.0, 0.0], (len(places), 1)))


OBSTACLE = Detection(centre=np.zeros(2), radius=3.0, distance=20.0, sigma=1.0)


def test_a_thing_shows_a_new_side_to_who_is_near_looks_and_sees_it(floor):
    floor.occupied |= floor.disc(np.array([0.0, 8.0]), 2.0)
    views = views_of_the_middle((13.0, 0.0), (40.0, 0.0), (0.0, 14.0), (-13.0, 0.0))
    away = Candidates(places=views.places, targets=views.targets + np.array([400.0, 0, 0]))
    assert new_sides(views, [OBSTACLE], floor, FIELD, 20.0).tolist() == [1.0, 0.0, 0.0, 1.0]
    assert new_sides(away, [OBSTACLE], floor, FIELD, 20.0).tolist() == [0.0, 0.0, 0.0, 1.0]


@settings(deadline=None, max_examples=40)
@given(st.lists(st.floats(-10, 10), min_size=1, max_size=8))
def test_the_widest_gap_is_at_least_an_even_share(bearings):
    gap = widest_gap(np.array(bearings))
    assert 2 * np.pi / len(bearings) - 1e-9 <= gap <= 2 * np.pi + 1e-9
    assert gap == pytest.approx(widest_gap(np.array(bearings) + 1.0), abs=1e-6)


def test_the_widest_gap_of_three_even_views_is_a_third():
    assert widest_gap(np.array([0.1, 0.1 + 2 * np.pi / 3, 0.1 - 2 * np.pi / 3])) == pytest.approx(
        2 * np.pi / 3
    )
    assert widest_gap(np.empty(0)) == 2 * np.pi


def test_a_place_is_put_into_a_way_where_it_is_cheapest():
    way = np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]])
    detour, position = insertion(way, np.array([[5.0, 0.0], [15.0, 3.0], [25.0, 0.0], [-4.0, 0]]))
    assert position.tolist() == [1, 2, 3, 1]
    assert detour == pytest.approx([0.0, 2 * np.hypot(5, 3) - 10, 5.0, 8.0])


def test_a_round_begins_with_what_is_near(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    unknown[:20, 50:70] = unknown[100:, 50:70] = True
    visibility = visibility_from(floor, (-20.0, 0.0), (0.0, 0.0), (20.0, 0.0), reach=45.0)
    place, azimuth = first_stop(floor, unknown, visibility, np.array([15.0, 0.0]), SCALES)
    assert place.tolist() == [20.0, 0.0]
    assert np.cos(azimuth) > np.cos(FIELD / 2)


def test_a_round_over_known_ground_has_no_stop(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    assert (
        first_stop(floor, unknown, visibility_from(floor, (0.0, 0.0)), np.zeros(2), SCALES) is None
    )
