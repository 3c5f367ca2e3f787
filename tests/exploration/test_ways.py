"""Ways round discs, against tangents and arcs."""

from types import SimpleNamespace

import numpy as np
import pytest

from recon.exploration.tour import Tour
from recon.exploration.ways import Ways, discs_of, lengths_between

DISC = np.array([[0.0, 0.0, 5.0]])
EAST = np.array([10.0, 0.0])


def way(*place, end=EAST, discs=DISC):
    (length,) = lengths_between(np.array([place], dtype=float), end, discs)
    return length


def test_way_past_a_disc_is_straight():
    assert way(-10.0, 20.0) == pytest.approx(np.hypot(20.0, 20.0))
    assert way(-10.0, 0.0, discs=np.empty((0, 3))) == 20.0


def test_way_round_a_disc_is_two_tangents_and_an_arc():
    tangent, arc = np.sqrt(75.0), 5.0 * (np.pi - 2.0 * np.arccos(0.5))
    assert way(-10.0, 0.0) == pytest.approx(2.0 * tangent + arc)


def test_way_between_two_sides_of_a_disc_follows_its_edge():
    assert way(0.0, 5.0, end=np.array([0.0, -5.0])) == pytest.approx(5.0 * np.pi)


def test_way_from_within_a_disc_is_never_shorter_than_straight():
    for place in ((0.0, 0.0), (1.0, 2.0), (-3.0, 0.0)):
        assert way(*place) >= np.hypot(*(EAST - place))


def test_ways_are_as_long_in_both_directions():
    places = np.random.default_rng(3).uniform(-20, 20, (30, 2))
    both = np.array([lengths_between(places, end, DISC) for end in places])
    assert both == pytest.approx(both.T)


def test_discs_are_obstacles_with_their_clearance():
    tree = SimpleNamespace(centre=np.array([3.0, 4.0]), radius=2.0)
    assert discs_of([tree], 3.0).tolist() == [[3.0, 4.0, 5.0]]
    assert discs_of([], 3.0).shape == (0, 3)


def test_tour_visits_what_lies_behind_an_obstacle_last():
    """The stop opposite is nearer as the crow flies, but not on foot."""
    places = np.array([[7.0, 0.0], [-7.0, 0.0], [7.0, 15.0]])
    for discs, last in ((np.empty((0, 3)), 2), (np.array([[0.0, 0.0, 6.9]]), 1)):
        tour = Tour(ways=Ways(places=places, lengths=np.array([0.0, 99.0, 99.0]), discs=discs))
        for place in (0, 1, 2):
            tour.insert(place, place, 0)
        tour.shorten()
        assert tour.stops[-1][0] == last


def test_ways_past_many_discs_add_up():
    """Each disc alone, although those that the straight line passes clear of are skipped."""
    rng = np.random.default_rng(4)
    places, end = rng.uniform(-20, 20, (200, 2)), np.array([3.0, -7.0])
    discs = np.column_stack([rng.uniform(-20, 20, (30, 2)), rng.uniform(0.5, 6.0, 30)])
    straight = np.hypot(*(places - end).T)
    added = [_round(places - disc[:2], end - disc[:2], disc[2]) - straight for disc in discs]
    expected = straight + np.maximum(added, 0.0).sum(axis=0)
    assert lengths_between(places, end, discs) == pytest.approx(expected)


def _round(starts, end, radius):
    """Two tangents and an arc (C,) about 0, or the straight way if that is clear of the disc."""
    away = np.maximum(np.hypot(*starts.T), radius)
    end_away = max(np.hypot(*end), radius)
    between = np.abs(np.angle((starts @ [1.0, 1.0j]) / (end @ [1.0, 1.0j])))
    arc = between - np.arccos(radius / away) - np.arccos(radius / end_away)
    tangents = np.sqrt(away**2 - radius**2) + np.sqrt(end_away**2 - radius**2)
    return np.where(arc > 0.0, tangents + radius * arc, np.hypot(*(starts - end).T))
