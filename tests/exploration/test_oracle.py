"""The oracle's tour in worlds with a known best tour."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from recon.exploration.floor import Floor
from recon.exploration.oracle import oracle_path
from recon.exploration.scales import Scales
from recon.settings import Settings

SCALES = Scales.of(Settings())
START = np.zeros(2)


@dataclass
class Tree:
    centre: np.ndarray
    size: np.ndarray = field(default_factory=lambda: np.array([6.0, 9.0, 6.0]))


def length(*centres, walls=(), start=START):
    floor = Floor(size_x=160, size_z=160)
    free = np.ones(floor.shape, dtype=bool)
    for x, z in centres:
        free &= ~floor.disc(np.array([x, z]), 3.0)
    for wall in walls:
        free[wall] = False
    trees = [Tree(np.array([x, 4.5, z])) for x, z in centres]
    return oracle_path(start, trees, free, floor, SCALES)


def test_empty_world_has_a_tour_of_zero_length():
    assert length() == 0.0


def test_tour_of_one_tree_goes_there_and_half_around_it():
    radius = 3.0 + 0.2 * 20.0
    arc = radius * 2.0 * np.pi / 3.0
    assert 40.0 - radius < length((40.0, 0.0)) < 40.0 - radius + 2.3 * arc


def test_wall_makes_the_tour_longer():
    wall = (slice(100, 103), slice(20, 140))
    assert length((40.0, 0.0), walls=[wall]) > length((40.0, 0.0)) + 40.0


def test_enclosed_object_has_no_tour():
    closed = [
        (slice(90, 151), slice(50, 53)), (slice(90, 151), slice(108, 111)),
        (slice(90, 93), slice(50, 111)), (slice(148, 151), slice(50, 111)),
    ]  # fmt: skip
    assert length((40.0, 0.0), walls=closed) is None


def test_ground_closed_in_behind_an_object_is_no_stop():
    pocket = [
        (slice(121, 124), slice(68, 93)), (slice(138, 141), slice(68, 93)),
        (slice(121, 141), slice(68, 71)), (slice(121, 141), slice(90, 93)),
    ]  # fmt: skip
    around = length((40.0, 0.0), walls=[(slice(121, 141), slice(68, 93))])
    assert length((40.0, 0.0), walls=pocket) == pytest.approx(around)


def test_world_in_another_unit_has_the_same_tour():
    floor = Floor(size_x=16.0, size_z=16.0, cell_size=0.1)
    free = ~floor.disc(np.array([4.0, 0.0]), 0.3)
    scales = Scales(
        cell=0.1, clearance=1.0, walk_clearance=0.3, viewing_distance=2.0, eye_height=0.5
    )
    tree = Tree(np.array([4.0, 0.45, 0.0]), np.array([0.6, 0.9, 0.6]))
    assert 10 * oracle_path(START, [tree], free, floor, scales) == pytest.approx(
        length((40.0, 0.0)), rel=1e-6
    )
