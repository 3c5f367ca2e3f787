"""Glances: an unsure agent turns to what it knows, a sure one goes on."""

import math

import numpy as np
import pytest

from recon.exploration.glances import Field, glance, turned
from recon.exploration.landmarks import NEW, UNCLEAR, Sighter
from recon.exploration.outlines import Outline
from recon.localisation.graph import Graph
from recon.records import View

FOCAL_PX, FIELD = 150.0, Field(half_rad=math.radians(40.0), reach=90.0)
STEP_SIGMA = (0.1, math.radians(1.0))
WAY = np.array([10.0, 0.0, 0.0])


def outline(azimuth, half, distance, is_free=(True, True)):
    return Outline(
        edges_rad=np.array([azimuth - half, azimuth + half]), is_free=np.array(is_free),
        distance=distance, sigma=0.01 * distance,
    )  # fmt: skip


def walker(*azimuths):
    """Things 40 units from the start in some directions, and one step on along x."""
    graph = Graph.at(np.zeros(3), STEP_SIGMA)
    sighter = Sighter.of(graph, FOCAL_PX)
    for azimuth in azimuths:
        sighter.add(outline(azimuth, 0.1, 40.0))
    graph.walk(WAY)
    graph.solve()
    return Sighter.of(graph, FOCAL_PX)


def heading(sighter, sure=0.1, arm=20.0):
    return glance(sighter, STEP_SIGMA, FIELD, sure, arm)


def test_an_unsure_agent_turns_to_a_known_thing():
    sighter = walker(1.5)
    turn = heading(sighter)
    offset = sighter.graph.landmarks[0, :2] - sighter.graph.poses[-1, :2]
    away = math.remainder(turn - math.atan2(offset[1], offset[0]), 2.0 * math.pi)
    assert abs(away) < FIELD.half_rad


def test_of_one_thing_and_two_it_turns_to_the_two():
    sighter = walker(1.5, -1.2, -1.9)
    assert math.sin(heading(sighter)) < 0.0


def test_a_sure_agent_and_one_that_knows_nothing_go_on():
    assert heading(walker(1.5), sure=9.0) is None
    assert heading(walker()) is None


def test_a_known_thing_is_known_again_and_another_is_new():
    sighter = walker(0.5, -0.5)
    middle, front = sighter.expected.azimuth_rad, sighter.expected.front
    half = sighter.expected.half_rad
    assert sighter.known(outline(middle[1] + 0.01, half[1], front[1])) == 1
    assert sighter.known(outline(middle[0] + 0.5, 0.1, 30.0)) == NEW
    assert sighter.known(outline(middle[0], 0.1, 4.0 * front[0])) == NEW
    assert sighter.known(outline(middle[0] + 0.15, half[0], front[0])) == UNCLEAR


def test_one_free_edge_tells_the_middle_less_surely():
    sighter = walker(0.5)
    middle, half = sighter.expected.azimuth_rad[0], sighter.expected.half_rad[0]
    front = float(sighter.expected.front[0])
    whole = sighter.bearing(outline(middle, half, front), 0)
    cut = sighter.bearing(outline(middle - half / 2, half / 2, front, (True, False)), 0)
    assert cut.azimuth_rad == pytest.approx(whole.azimuth_rad, abs=1e-6)
    assert cut.azimuth_sigma > 2.0 * whole.azimuth_sigma
    assert np.isnan(cut.half_rad)


def test_a_turned_view_stands_where_it_stood():
    view = View(position=np.array([1.0, 5.0, 2.0]), target=np.array([9.0, 5.0, 2.0]))
    other = turned(view, math.pi / 2.0, 20.0)
    assert np.array_equal(other.position, view.position)
    assert other.target == pytest.approx([1.0, 5.0, 22.0])


def test_a_thing_much_narrower_than_a_landmark_is_not_that_landmark():
    sighter = walker(0.5)
    expected = sighter.expected
    azimuth, half, away = (
        float(one[0]) for one in (expected.azimuth_rad, expected.half_rad, expected.front)
    )
    assert sighter.known(outline(azimuth, half, away)) == 0
    assert sighter.known(outline(azimuth, half / 3.0, away)) == UNCLEAR
    # One edge does not show a width.
    assert sighter.known(outline(azimuth, half / 3.0, away, (True, False))) != NEW


def test_a_heading_that_was_tried_is_not_tried_again():
    sighter = walker(1.5, -1.2, -1.9)
    first = heading(sighter)
    again = glance(sighter, STEP_SIGMA, FIELD, 0.1, 20.0, [first])
    assert again != first
    headings = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False).tolist()
    assert glance(sighter, STEP_SIGMA, FIELD, 0.1, 20.0, headings) is None
