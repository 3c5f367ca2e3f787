"""Metrics of an exploration, on paths with known values."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from recon.errors import InputError
from recon.exploration.floor import Floor
from recon.exploration.metrics import (
    length_of,
    pairs_until_objects,
    path_between,
    path_bound,
)
from recon.exploration.referee import Referee
from recon.exploration.state import Walk
from recon.records import FoundObject, View
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland

SMALL = updated(Settings(), {"world": {"size_x": 40.0, "size_z": 40.0}})


def view(x, z, **more):
    kind = Walk if more else View
    return kind(position=np.array([x, 5.0, z]), target=np.array([x, 5.0, z - 9.0]), **more)


def found(label, x=0.0, z=0.0):
    return FoundObject(
        id=0, label=label, probability=1.0, centre=np.array([x, 4.0, z]),
        size=np.array([6.0, 8.0, 6.0]), num_voxels=50,
    )  # fmt: skip


@pytest.fixture
def referee():
    return Referee(world=Flatland(discs=[(10.0, 0.0, 3.0, 9.0)], settings=SMALL), settings=SMALL)


def test_path_length_is_measured_along_its_corners():
    path = path_between(view(0, 0), view(4, 0, via=np.array([[0.0, 5.0, 3.0]])))
    assert length_of(path) == pytest.approx(3.0 + 5.0)


def test_clearance_is_measured_from_the_axis_along_the_whole_path(referee):
    assert referee.walk(path_between(view(5, -15), view(5, 15))) is None
    assert referee.min_clearance == pytest.approx(2.0, abs=1e-3)


def test_start_counts_for_the_clearance(referee):
    referee.check_start(view(0, 0))
    assert referee.min_clearance == pytest.approx(7.0)


@pytest.mark.parametrize("x", [10.0, 7.4, 12.0])
def test_start_in_or_at_an_object_is_rejected(referee, x):
    with pytest.raises(InputError, match=rf"start_position: x {x:g}, z 0 is inside or"):
        referee.check_start(view(x, 0))


@pytest.mark.parametrize("end", [view(20, 0), view(10, 0), view(6.6, 0)])
def test_path_into_an_obstacle_is_blocked_and_not_counted(referee, end):
    contact = referee.walk(path_between(view(0, 0), end))
    assert np.allclose(contact, [6.5, 0.0], atol=0.1)
    assert referee.min_clearance == np.inf


def test_path_on_which_the_body_grazes_an_obstacle_is_blocked(referee):
    assert referee.walk(path_between(view(6.4, -15), view(6.4, 15))) is None
    assert referee.walk(path_between(view(6.6, -15), view(6.6, 15))) is not None


def test_coverage_counts_free_cells_only(referee):
    floor = Floor(size_x=40, size_z=40)
    assert referee.coverage(floor) == 0.0
    floor.seen_from[:20] = 1.0
    free = 1600 - np.pi * 9
    assert referee.coverage(floor) == pytest.approx(800 / free, rel=0.01)
    floor.seen_from[:] = 1.0
    assert referee.coverage(floor) == 1.0


@dataclass
class Obstacle:
    centre: np.ndarray
    size: np.ndarray = field(default_factory=lambda: np.array([4.0, 8.0, 4.0]))


def test_path_bound_is_the_spanning_tree_of_viewing_discs():
    start = view(0, 0)
    assert path_bound(start, [], 10.0) == 0.0
    assert path_bound(start, [Obstacle(np.array([9.0, 4, 0]))], 10.0) == pytest.approx(
        0.0, abs=1e-6
    )
    far = [Obstacle(np.array([50.0, 4, 0])), Obstacle(np.array([0.0, 4, 100.0]))]
    assert path_bound(start, far[:1], 10.0) == pytest.approx(38.0, abs=1e-6)
    assert path_bound(start, far, 10.0) == pytest.approx(38.0 + 87.8034, abs=1e-3)


@pytest.mark.parametrize(
    ("timeline", "pairs"),
    [
        ([(3, []), (5, ["apple tree"]), (9, ["apple tree"])], 5),
        ([(3, ["apple tree"]), (5, ["cottage"]), (7, ["apple tree"]), (9, ["apple tree"])], 7),
        ([(3, ["cottage"]), (9, ["apple tree"])], 9),
    ],
)
def test_object_counts_from_when_its_label_became_final(timeline, pairs):
    told = [(number, [found(label) for label in labels]) for number, labels in timeline]
    assert pairs_until_objects(told, [found("apple tree", 0.4)]) == pairs


def test_last_object_counts_and_a_moved_one_is_another_object():
    near, far = found("cottage"), found("cottage", x=30.0)
    told = [(2, [near]), (6, [near, far]), (8, [near, far])]
    assert pairs_until_objects(told, [near]) == 2
    assert pairs_until_objects(told, [near, far]) == 6
    assert pairs_until_objects(told, []) == 0
