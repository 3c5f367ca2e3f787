"""Glances: an uncertain agent turns to known landmarks, a certain one continues."""

import math

import numpy as np
import pytest

from recon.exploration.association import NEW, UNCLEAR, associated
from recon.exploration.glances import Field, glance, turned
from recon.exploration.landmarks import Sighter
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
    """Place landmarks 40 units from the start in some directions, and walk one step along x."""
    graph = Graph.at(np.zeros(3), STEP_SIGMA)
    sighter = Sighter.of(graph, FOCAL_PX)
    for azimuth in azimuths:
        sighter.add(outline(azimuth, 0.1, 40.0))
    graph.walk(WAY)
    graph.solve()
    return Sighter.of(graph, FOCAL_PX)


def known(sighter, one):
    return associated(sighter, [one])[0]


def heading(sighter, sure=0.1, arm=20.0):
    return glance(sighter, STEP_SIGMA, FIELD, sure, arm)


def test_uncertain_agent_turns_to_a_known_landmark():
    sighter = walker(1.5)
    turn = heading(sighter)
    offset = sighter.graph.landmarks[0, :2] - sighter.graph.poses[-1, :2]
    away = math.remainder(turn - math.atan2(offset[1], offset[0]), 2.0 * math.pi)
    assert abs(away) < FIELD.half_rad


def test_agent_prefers_a_view_of_two_landmarks():
    sighter = walker(1.5, -1.2, -1.9)
    assert math.sin(heading(sighter)) < 0.0


def test_certain_agent_or_one_without_landmarks_does_not_turn():
    assert heading(walker(1.5), sure=9.0) is None
    assert heading(walker()) is None


def test_landmark_is_recognised_and_another_is_new():
    sighter = walker(0.5, -0.5)
    middle, front = sighter.expected.azimuth_rad, sighter.expected.front
    half = sighter.expected.half_rad
    assert known(sighter, outline(middle[1] + 0.01, half[1], front[1])) == 1
    assert known(sighter, outline(middle[0] + 0.5, 0.1, 30.0)) == NEW
    assert known(sighter, outline(middle[0], 0.1, 4.0 * front[0])) == NEW
    assert known(sighter, outline(middle[0] + 0.15, half[0], front[0])) == UNCLEAR


def test_single_visible_edge_gives_a_less_certain_centre():
    sighter = walker(0.5)
    middle, half = sighter.expected.azimuth_rad[0], sighter.expected.half_rad[0]
    front = float(sighter.expected.front[0])
    whole = sighter.bearing(outline(middle, half, front), 0)
    cut = sighter.bearing(outline(middle - half / 2, half / 2, front, (True, False)), 0)
    assert cut.azimuth_rad == pytest.approx(whole.azimuth_rad, abs=1e-6)
    assert cut.azimuth_sigma > 2.0 * whole.azimuth_sigma
    assert np.isnan(cut.half_rad)


def test_turned_view_keeps_its_position():
    view = View(position=np.array([1.0, 5.0, 2.0]), target=np.array([9.0, 5.0, 2.0]))
    other = turned(view, math.pi / 2.0, 20.0)
    assert np.array_equal(other.position, view.position)
    assert other.target == pytest.approx([1.0, 5.0, 22.0])


def test_much_narrower_object_is_not_matched_to_a_landmark():
    sighter = walker(0.5)
    expected = sighter.expected
    azimuth, half, away = (
        float(one[0]) for one in (expected.azimuth_rad, expected.half_rad, expected.front)
    )
    assert known(sighter, outline(azimuth, half, away)) == 0
    assert known(sighter, outline(azimuth, half / 3.0, away)) == UNCLEAR
    # A single edge gives no width.
    assert known(sighter, outline(azimuth, half / 3.0, away, (True, False))) != NEW


def test_tried_heading_is_not_tried_again():
    sighter = walker(1.5, -1.2, -1.9)
    first = heading(sighter)
    again = glance(sighter, STEP_SIGMA, FIELD, 0.1, 20.0, [first])
    assert again != first
    headings = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False).tolist()
    assert glance(sighter, STEP_SIGMA, FIELD, 0.1, 20.0, headings) is None
