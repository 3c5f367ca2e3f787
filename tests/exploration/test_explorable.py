"""Explorable sources: worlds in any unit, and recordings without truth."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exploration.agent import explore
from recon.mapping import mapper
from recon.records import View
from recon.settings import Settings, updated
from tests.exploration.flatland import Flatland, in_units

TREES = [(20.0, 12.0, 4.0, 14.0), (-25.0, 8.0, 6.0, 12.0)]


class Recording:
    """Recorded pairs around a tree: a source with only a start and pairs."""

    def __init__(self, world, scale):
        around = np.radians(np.arange(0.0, 360.0, 45.0))
        tree = scale * np.array([20.0, 5.0, 12.0])
        offsets = np.column_stack([np.cos(around), np.zeros(8), np.sin(around)])
        self.views = [View(position=tree + scale * 14.0 * o, target=tree) for o in offsets]
        self.pairs = [world.take(view) for view in self.views]

    def start(self):
        return self.views[0]

    def take(self, view):
        apart = [np.linalg.norm(view.position - other.position) for other in self.views]
        return self.pairs[int(np.argmin(apart))]


class Replay:
    """A controller that replays the views of a recording."""

    def __init__(self, views):
        self.views = list(views)

    def next_view(self, state):
        assert state.simulator is None
        return self.views.pop(0) if self.views else None

    def info(self):
        return "a replay"

    def result(self):
        return "the recording is over"


def test_recorded_source_with_small_cells_is_explored_without_truth(monkeypatch):
    settings = in_units(updated(Settings(), {"world": {"size_x": 80.0, "size_z": 80.0}}), 0.1)
    assert settings.map.cell_size == pytest.approx(0.1)
    world = Flatland(discs=0.1 * np.array(TREES), settings=settings)
    monkeypatch.setattr(mapper, "match_points", world.match_points)
    recording = Recording(world, 0.1)
    done = explore(recording, settings, controller=Replay(recording.views[1:]))
    assert (done.stop_reason, done.message) == ("controller ended", "the recording is over")
    near = [
        o for o in done.recognition.objects if np.hypot(*(o.centre - [2, 0, 1.2])[[0, 2]]) < 0.1
    ]
    assert len(near) == 1
    assert near[0].size[[0, 2]] == pytest.approx(0.8, abs=0.12)
    assert done.metrics["num_pairs"] == 8
    ring = 7 * 2 * 1.4 * np.sin(np.pi / 8)
    assert done.metrics["path_length"] == pytest.approx(ring)
    truths = ("coverage", "min_clearance", "path_bound", "oracle_path")
    assert [done.metrics[name] for name in truths] == [None] * 4
    assert {share for _, _, share in done.metrics["curve"]} == {None}


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_world_in_another_unit_gives_the_same_walk(explore_discs, scale):
    one, other = (
        explore_discs([(12.0, 6.0, 4.0, 14.0)], size=56.0, scale=unit) for unit in (1.0, scale)
    )
    assert other.stop_reason == one.stop_reason == "all known"
    assert len(other.recognition.objects) == len(one.recognition.objects) >= 1
    assert other.metrics["num_pairs"] == pytest.approx(one.metrics["num_pairs"], rel=0.1)
    assert other.metrics["path_length"] == pytest.approx(
        scale * one.metrics["path_length"], rel=0.1
    )
    assert other.metrics["coverage"] == pytest.approx(one.metrics["coverage"], abs=0.01)


@pytest.mark.parametrize(
    ("heading", "ahead"), [(0.0, (0, -1)), (90.0, (1, 0)), (180.0, (0, 1)), (-90.0, (-1, 0))]
)
def test_start_is_a_setting(explore_discs, heading, ahead):
    done = explore_discs(TREES, max_pairs=1, start_position=(-5.0, 30.0), start_heading_deg=heading)
    (view,) = done.views
    assert view.position.tolist() == [-5.0, 5.0, 30.0]
    gaze = (view.target - view.position)[[0, 2]]
    assert gaze / np.hypot(*gaze) == pytest.approx(ahead, abs=1e-9)
    high = explore_discs(TREES, max_pairs=1, start_position=(-5.0, 7.0, 30.0))
    assert high.views[0].position.tolist() == [-5.0, 7.0, 30.0]


@pytest.mark.parametrize("place", [(20.0, 12.0), (16.2, 12.0), (15.8, 12.0)])
def test_start_in_or_at_an_object_is_rejected(explore_discs, place):
    with pytest.raises(InputError, match=r"start_position: x .* inside or against an object"):
        explore_discs(TREES, start_position=place)


def test_start_outside_the_floor_is_rejected(explore_discs):
    with pytest.raises(InputError, match=r"x 90, z 0 is off the floor of 100 x 100"):
        explore_discs(TREES, start_position=(90.0, 0.0))
