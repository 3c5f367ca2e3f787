"""Expected gains of views, and tours of views."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recon.exploration.floor import Floor
from recon.exploration.gains import NUM_RAYS, SPACING_RAD, Visibility
from recon.exploration.gaps import LAST, LEAST
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.exploration.search import MAX_LOOKS, Look, Search, are_nameable
from recon.exploration.sides import Sides, is_given_up, widest_gap
from recon.exploration.tour import EARLY, Tour, first_stop
from recon.exploration.ways import Ways
from recon.settings import Settings

FIELD = np.radians(80.0)
SCALES = Scales.of(Settings())


@pytest.fixture
def floor():
    return Floor(size_x=120, size_z=120)


def visibility_from(floor, *places, reach=40.0):
    places = np.array(places, dtype=np.float64)
    return Visibility.over(floor, places, FIELD, reach, np.ones(floor.shape, dtype=bool))


def test_view_of_unknown_ground_shows_its_field(floor):
    area = visibility_from(floor, (0.0, 0.0)).area(~floor.occupied)
    assert area.shape == (1, NUM_RAYS)
    assert area == pytest.approx(0.5 * FIELD * 40.0**2, rel=0.06)


def test_obstacle_and_border_hide_ground(floor):
    floor.occupied |= floor.disc(np.array([15.0, 0.0]), 4.0)
    area = visibility_from(floor, (0.0, 0.0), (55.0, 0.0)).area(~floor.occupied)
    east, west = ray_of(np.array([0.0, np.pi]))
    assert 0.4 * area[0, west] < area[0, east] < 0.8 * area[0, west]
    assert area[1, east] < 0.2 * area[1, west]


def test_taken_view_shows_nothing_new(floor):
    visibility = visibility_from(floor, (0.0, 0.0), (20.0, 0.0)).without([(np.zeros(2), 0.0)], 3.0)
    area = visibility.area(~floor.occupied)
    assert area[0, ray_of(np.array([0.2]))[0]] == 0.0
    assert area[0, ray_of(np.array([0.5]))[0]] > 0.0
    assert area[1, 0] > 0.0


def ray_of(azimuths_rad):
    return np.rint(azimuths_rad / SPACING_RAD).astype(int) % NUM_RAYS


OBSTACLE = Detection(centre=np.zeros(2), radius=3.0, distance=20.0, sigma=1.0)
ALL_ROUND = [(13.0, 0.0), (-6.5, 11.26), (-6.5, -11.26)]


def searching(looks=(), expects_names=True):
    return Search(clearance=10.0, reach=20.0, looks=[*looks], expects_names=expects_names)


def sides_from(floor, *places, looks=(), expects_names=True):
    search = searching(looks, expects_names)
    return Sides.of([OBSTACLE], np.array(places, dtype=float), floor, FIELD, search)


def test_view_from_nearer_than_wanted_shows_no_side(floor):
    """From 13 units, the edge of the obstacle is 10 units away."""
    for least, is_shown in ((0.0, True), (9.9, True), (10.1, False)):
        search = replace(searching(), least=least)
        sides = Sides.of([OBSTACLE], np.array([[13.0, 0.0]]), floor, FIELD, search)
        assert (sides.shown > 0.0).all() == is_shown


def test_unseen_side_counts_only_if_near_in_view_and_visible(floor):
    floor.occupied |= floor.disc(np.array([0.0, 8.0]), 2.0)
    worth = sides_from(floor, (13.0, 0.0), (40.0, 0.0), (0.0, 14.0), (-13.0, 0.0)).worth
    west, east = ray_of(np.array([np.pi, 0.0]))
    assert worth[[0, 3], [west, east]] == pytest.approx(1.0, abs=0.05)
    assert not worth[[0, 3], [east, west]].any()
    assert not worth[[1, 2]].any()
    assert worth[0].max() == worth[0, west]


def test_three_even_views_show_every_side_once(floor):
    sides = sides_from(floor, *ALL_ROUND)
    shown = []
    for place in range(3):
        shown.append(sides.shown[0, place])
        sides, changed = sides.after(place, sides.azimuth[0, place])
        assert place in changed
        assert sides.shown[0, place] == 0.0
        assert sides.worth.max(axis=1) == pytest.approx(sides.shown[0], abs=0.01)
    assert not sides.missing.any()
    assert shown[0] == pytest.approx(1.0, abs=0.05)
    assert 0.7 < shown[1] < 1.0
    assert LAST <= shown[2] < shown[1]


def test_more_views_are_planned_of_an_obstacle_where_no_name_is_expected(floor):
    sides, _ = sides_from(floor, *ALL_ROUND, expects_names=False).after(0, np.pi)
    for place in (1, 2):
        sides, _ = sides.after(place, sides.azimuth[0, place])
    assert sides.missing.any()


def test_one_view_is_planned_of_a_detection_that_may_be_far_from_where_it_seems(floor):
    """Of one that is less certain than the distance of 10 units from which it would be viewed."""
    place, search = np.array([[13.0, 0.0]]), searching()
    for sigma, is_done in ((9.9, False), (10.1, True)):
        sides = Sides.of([replace(OBSTACLE, sigma=sigma)], place, floor, FIELD, search)
        assert sides.worth.max() == pytest.approx(1.0, abs=0.05)
        assert sides.after(0, np.pi)[0].missing.any() != is_done


def test_names_are_expected_until_most_named_obstacles_have_none():
    sure, unsure, unnamed = (
        SimpleNamespace(found=found, is_sure=found == "tree") for found in ("tree", "unknown", None)
    )
    assert are_nameable([])
    assert are_nameable([unnamed, sure, unsure])
    assert not are_nameable([unnamed, sure, unsure, unsure])


def test_opposite_view_is_worth_little_as_it_leaves_two_gaps(floor):
    opposite, *others = (-13.0, 0.0), *ALL_ROUND
    sides, _ = sides_from(floor, *others, opposite).after(0, np.pi)
    assert 0.0 < sides.shown[0, 3] <= LEAST
    assert (sides.shown[0, 1:3] > 0.7).all()


def test_view_away_from_an_obstacle_leaves_its_sides_missing(floor):
    sides = sides_from(floor, (13.0, 0.0))
    left, changed = sides.after(0, 0.0)
    assert left.missing.all()
    assert not len(changed)
    assert sides.target(0, np.pi) is OBSTACLE
    assert sides.target(0, np.pi / 2) is None


def test_side_that_stays_unseen_after_several_views_is_given_up(floor):
    look = Look(place=np.array([13.0, 0.0]), centre=np.array([0.5, 0.5]))
    elsewhere = Look(place=np.array([13.0, 0.0]), centre=np.array([9.0, 0.0]))
    for looks in ([look] * (MAX_LOOKS - 1), [elsewhere] * MAX_LOOKS):
        assert sides_from(floor, *ALL_ROUND, looks=looks).missing.all()
    given_up = sides_from(floor, *ALL_ROUND, looks=[look] * MAX_LOOKS)
    assert given_up.shown[0, 0] == 0.0
    assert (given_up.shown[0, 1:] > 0.0).all()
    assert not is_given_up(OBSTACLE, searching([look] * MAX_LOOKS))
    all_round = [Look(place=np.array(place), centre=np.zeros(2)) for place in ALL_ROUND]
    assert is_given_up(OBSTACLE, searching(all_round * MAX_LOOKS))
    assert not is_given_up(OBSTACLE, searching(all_round * (MAX_LOOKS - 1)))


@settings(max_examples=40)
@given(st.lists(st.floats(-10, 10), min_size=1, max_size=8))
def test_widest_gap_is_at_least_an_even_share(bearings):
    gap = widest_gap(np.array(bearings))
    assert 2 * np.pi / len(bearings) - 1e-9 <= gap <= 2 * np.pi + 1e-9
    assert gap == pytest.approx(widest_gap(np.array(bearings) + 1.0), abs=1e-6)


def test_widest_gap_of_three_even_views_is_a_third():
    assert widest_gap(np.array([0.1, 0.1 + 2 * np.pi / 3, 0.1 - 2 * np.pi / 3])) == pytest.approx(
        2 * np.pi / 3
    )
    assert widest_gap(np.empty(0)) == 2 * np.pi


def tour_past(*stops, places):
    places = np.array(places, dtype=float)
    tour = Tour(ways=Ways(places=places, lengths=np.hypot(*places.T)))
    for position, stop in enumerate(stops):
        tour.insert(position, stop, 0)
    return tour


PLACES = [(10.0, 0.0), (20.0, 0.0), (5.0, 0.0), (15.0, 3.0), (25.0, 0.0), (-5.0, 0.0)]


def test_place_is_inserted_into_a_tour_where_cheapest():
    detour, position = tour_past(0, 1, places=PLACES).detours()
    assert position[2:].tolist() == [0, 1, 2, 0]
    assert detour[2:] == pytest.approx([0.0, 2 * np.hypot(5, 3) - 10, 5.0, 10.0])


def test_early_detour_costs_more_than_a_later_one():
    detour, position = tour_past(0, 1, places=PLACES).detours(EARLY)
    assert position[2:].tolist() == [0, 1, 2, 2]
    assert detour[2:] == pytest.approx([0.0, EARLY * (2 * np.hypot(5, 3) - 10), 5.0, 25.0])


def test_tour_is_shortened_and_keeps_its_start():
    tour = tour_past(1, 0, 4, places=PLACES)
    tour.shorten()
    assert [place for place, _ in tour.stops] == [0, 1, 4]


def stop_of(floor, unknown, visibility, start, reached=None):
    places = visibility.places
    ways = Ways(places=places, lengths=np.hypot(*(places - start).T))
    sides = Sides.of([], places, floor, FIELD, searching())
    reached = np.ones(len(places), dtype=bool) if reached is None else np.array(reached)
    return first_stop(ways, visibility, sides, unknown, SCALES, reached)


def test_tour_starts_with_nearby_places(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    unknown[:20, 50:70] = unknown[100:, 50:70] = True
    visibility = visibility_from(floor, (-20.0, 0.0), (0.0, 0.0), (20.0, 0.0), reach=45.0)
    place, azimuth = stop_of(floor, unknown, visibility, np.array([15.0, 0.0]))
    assert place == 2
    assert np.cos(azimuth) > np.cos(FIELD / 2)


def test_ground_is_only_looked_at_from_reached_places(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    unknown[100:, 50:70] = True
    visibility = visibility_from(floor, (0.0, 0.0), (20.0, 0.0), reach=45.0)
    place, _ = stop_of(floor, unknown, visibility, np.array([15.0, 0.0]))
    assert place == 1
    place, _ = stop_of(floor, unknown, visibility, np.array([15.0, 0.0]), [True, False])
    assert place == 0


def test_tour_over_known_ground_has_no_stop(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    visibility = visibility_from(floor, (0.0, 0.0))
    assert stop_of(floor, unknown, visibility, np.zeros(2)) is None


def test_little_unknown_ground_is_not_worth_a_long_path(floor):
    unknown = np.zeros(floor.shape, dtype=bool)
    unknown[:10, 50:70] = True
    visibility = visibility_from(floor, (-30.0, 0.0))
    assert unknown.mean() < 0.02
    assert stop_of(floor, unknown, visibility, np.array([0.0, 0.0])) is not None
    assert stop_of(floor, unknown, visibility, np.array([50.0, 0.0])) is None
    unknown[:60] = True
    assert stop_of(floor, unknown, visibility, np.array([50.0, 0.0])) is not None


def test_cells_shown_by_a_view_are_removed(floor):
    floor.occupied |= floor.disc(np.array([15.0, 0.0]), 4.0)
    left = visibility_from(floor, (0.0, 0.0)).left(~floor.occupied, np.zeros(2), 0.0)
    assert not left[tuple(floor.cells([8.0, 3.0]))]
    assert left[tuple(floor.cells([25.0, 0.0]))]
    assert left[tuple(floor.cells([-8.0, 0.0]))]
