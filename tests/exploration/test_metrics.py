"""The numbers of an exploration, on walks whose numbers are known."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from recon.exploration.floor import Floor
from recon.exploration.metrics import Record, pairs_until_objects, path_bound
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
def record():
    return Record(world=Flatland(discs=[(10.0, 0.0, 3.0, 9.0)], settings=SMALL), baseline=0.3)


def test_a_way_is_measured_along_its_corners(record):
    assert record.walk(view(0, 0), view(4, 0, via=np.array([[0.0, 5.0, 3.0]])))
    assert record.path_length == pytest.approx(3.0 + 5.0)


def test_clearance_is_that_of_the_nearer_eye_along_the_whole_way(record):
    assert record.walk(view(5, -15), view(5, 15))
    assert record.min_clearance == pytest.approx(2.0 - 0.15, abs=1e-3)


def test_who_stands_still_has_a_clearance_too(record):
    assert record.walk(view(0, 0), view(0, 0))
    assert record.path_length == 0.0
    assert record.min_clearance == pytest.approx(7.0 - 0.15, abs=1e-6)


@pytest.mark.parametrize("end", [view(20, 0), view(10, 0)])
def test_a_way_into_a_thing_is_barred_and_not_counted(record, end):
    assert not record.walk(view(0, 0), end)
    assert record.path_length == 0.0
    assert record.min_clearance == np.inf


def test_coverage_counts_free_cells_only(record):
    floor = Floor(size_x=40, size_z=40)
    assert record.coverage(floor) == 0.0
    floor.seen_from[:20] = 1.0
    free = 1600 - np.pi * 9
    assert record.coverage(floor) == pytest.approx(800 / free, rel=0.01)
    floor.seen_from[:] = 1.0
    assert record.coverage(floor) == 1.0


@dataclass
class Thing:
    centre: np.ndarray
    size: np.ndarray = field(default_factory=lambda: np.array([4.0, 8.0, 4.0]))


def test_the_bound_is_the_gap_between_what_can_be_seen_from_one_place():
    start = view(0, 0)
    assert path_bound(start, [], 10.0) == 0.0
    assert path_bound(start, [Thing(np.array([9.0, 4, 0]))], 10.0) == pytest.approx(0.0, abs=1e-6)
    far = [Thing(np.array([50.0, 4, 0])), Thing(np.array([0.0, 4, 100.0]))]
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
def test_an_object_counts_from_when_it_had_its_label_for_good(timeline, pairs):
    told = [(number, [found(label) for label in labels]) for number, labels in timeline]
    assert pairs_until_objects(told, [found("apple tree", 0.4)]) == pairs


def test_the_last_object_counts_and_another_place_is_another_object():
    near, far = found("cottage"), found("cottage", x=30.0)
    told = [(2, [near]), (6, [near, far]), (8, [near, far])]
    assert pairs_until_objects(told, [near]) == 2
    assert pairs_until_objects(told, [near, far]) == 6
    assert pairs_until_objects(told, []) == 0
