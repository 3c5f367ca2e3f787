"""Objects that are ambiguous alone are associated together."""

import math

import numpy as np

from recon.exploration.association import UNCLEAR, associated
from recon.exploration.landmarks import Sighter
from recon.exploration.outlines import Outline
from recon.localisation.graph import Graph

FOCAL_PX = 150.0
HALF, AWAY = 0.03, 40.0


def outline(azimuth, distance=AWAY):
    return Outline(
        edges_rad=np.array([azimuth - HALF, azimuth + HALF]), is_free=np.array([True, True]),
        distance=distance, sigma=0.01 * distance,
    )  # fmt: skip


def turned(*azimuths):
    """Landmarks 40 units away, after a turn on the spot with a standard error of six degrees."""
    graph = Graph.at(np.zeros(3), (0.1, math.radians(6.0)))
    sighter = Sighter.of(graph, FOCAL_PX)
    for azimuth in azimuths:
        sighter.add(outline(azimuth))
    graph.walk(np.zeros(3))
    graph.solve()
    return Sighter.of(graph, FOCAL_PX)


def test_two_objects_are_associated_together():
    sighter = turned(0.0, 0.15)
    for azimuth in (0.06, 0.21):
        assert associated(sighter, [outline(azimuth)]) == [UNCLEAR]
    assert associated(sighter, [outline(0.06), outline(0.21)]) == [0, 1]
    assert associated(sighter, [outline(0.21), outline(0.06)]) == [1, 0]


def test_two_of_three_evenly_spaced_landmarks_are_ambiguous():
    sighter = turned(0.0, 0.15, 0.3)
    assert associated(sighter, [outline(0.07), outline(0.22)]) == [UNCLEAR, UNCLEAR]
    assert associated(sighter, [outline(0.07), outline(0.22), outline(0.37)]) == [0, 1, 2]


def test_object_at_a_unique_distance_resolves_the_others():
    sighter = turned(0.0, 0.15, 0.3)
    Sighter.of(sighter.graph, FOCAL_PX, 0).add(outline(0.0, 15.0))
    sighter.graph.solve()
    sighter = Sighter.of(sighter.graph, FOCAL_PX)
    seen = [outline(0.07), outline(0.22), outline(0.07, 15.0)]
    assert associated(sighter, seen) == [0, 1, 3]


def test_earlier_pair_is_associated_from_its_own_pose():
    sighter = turned(0.0, 0.15)
    graph = sighter.graph
    graph.walk(np.array([3.0, 0.0, 0.0]))
    graph.bearings.append(sighter.bearing(outline(0.06), 0))
    graph.solve()
    then = Sighter.of(graph, FOCAL_PX, 1)
    assert associated(then, [outline(0.21)]) == [1]
    assert then.bearing(outline(0.21), 1).pose == 1
