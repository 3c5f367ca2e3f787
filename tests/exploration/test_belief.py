"""An agent with motion errors corrects its pose by what it sees, and its map as well."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from recon.exploration import agent
from recon.exploration.agent import explore
from recon.exploration.belief import Belief, belief_of
from recon.exports.ply import CloudWriter, read_cloud_chunks
from recon.localisation.graph import Graph, planar
from recon.records import PointCloud, Trajectory, View
from recon.runs.outputs import move_cloud
from recon.settings import Settings, explorers, updated, with_quality
from recon.world.world import World
from tests.exploration.flatland import Flatland, nothing

NOISE = {
    "motion": {"position_noise": 0.2, "heading_noise_deg": 2.0, "noise_seed": 2},
}


class Round:
    """A controller that walks around the trees, looking at each."""

    def __init__(self):
        angles = np.radians([0.0, 40.0, 80.0, 120.0])
        self.places = [(-10 + 22 * np.sin(a), 5.0, -5 + 22 * np.cos(a)) for a in angles]

    def next_view(self, state):
        if not self.places:
            return None
        place = np.array(self.places.pop(0))
        return View(position=place, target=np.array([-10.0, 5.0, -5.0]))

    def info(self):
        return "round"

    def result(self):
        return "controller ended"


def walked(world_of):
    """Walk a round in a world; return the exploration, believed poses and true poses."""
    settings = updated(with_quality(explorers(Settings()), "fast"), NOISE)
    done = explore(world_of(settings), settings, controller=Round())
    return done, done.reconstruction.trajectory.T_world_left, done.true_trajectory.T_world_left


def off(believed, true):
    both = zip(believed, true, strict=True)
    return float(np.mean([np.hypot(*(planar(a) - planar(b))[:2]) for a, b in both]))


def test_believed_poses_are_better_than_dead_reckoning(monkeypatch):
    done, believed, true = walked(lambda settings: World.from_file("village", settings))
    assert done.metrics["pose_error_end"] > 0.0
    corrected = off(believed, true)
    assert len(believed) >= 5 + len(Round().places) + 1
    # It returns to the start with the same heading; the round itself ends 18 units away.
    assert np.linalg.norm(believed[-1, :3, 3] - believed[0, :3, 3]) < 3.0
    # At the start it looks all around, with as few views of 80 degrees as necessary.
    assert np.linalg.norm(np.ptp(believed[:5, :3, 3], axis=0)) < 3.0
    headings = np.unwrap([planar(T)[2] for T in true[:5]])
    assert np.degrees(headings[-1] - headings[0]) == pytest.approx(288.0, abs=25.0)
    monkeypatch.setattr(Belief, "correct", lambda self, sight, model: np.eye(4))
    monkeypatch.setattr(Belief, "outdated", lambda self: None)
    monkeypatch.setattr(Belief, "glance", lambda self: None)
    # Without corrections, its observations have no effect on its path.
    monkeypatch.setattr(agent, "match_points", lambda pair, settings: nothing())
    _, believed, true = walked(lambda settings: Flatland(discs=[], settings=settings))
    assert corrected < 0.5 * off(believed, true)


def test_exact_motion_needs_no_belief():
    assert belief_of(Settings()) is None
    assert belief_of(updated(Settings(), NOISE)).sigma == 0.0


def test_agent_ends_at_home_however_often_it_is_sent_out(monkeypatch):
    belief = belief_of(updated(Settings(), NOISE))
    belief.graph = Graph.at(np.zeros(3), (0.2, 0.03))
    belief.sights = [SimpleNamespace(view="first")]
    monkeypatch.setattr("recon.exploration.belief.way_home", lambda first, state: "home")
    said = itertools.cycle(["out", None])
    ways = [belief.onward(lambda _: next(said), None) for _ in range(20)]
    last = ways.index(None)
    assert set(ways[:last]) == {"out", "home"}
    assert ways[last - 1] == "home"
    assert ways[last:] == [None] * (20 - last)


def test_clearance_grows_with_uncertainty_up_to_a_limit(monkeypatch):
    belief = belief_of(updated(Settings(), NOISE))
    assert belief.cautious.exploration.walk_clearance == 3.0
    monkeypatch.setattr(Belief, "sigma", 0.25)
    assert belief.cautious.exploration.walk_clearance == pytest.approx(3.5)
    monkeypatch.setattr(Belief, "sigma", 9.0)
    assert belief.cautious.exploration.walk_clearance == pytest.approx(4.0)


def test_points_on_disk_follow_corrected_poses(tmp_path):
    path, poses = tmp_path / "cloud.ply", np.stack([np.eye(4), np.eye(4)])
    with CloudWriter(path) as writer:
        for number in (0, 1):
            writer.append(PointCloud(points=np.full((2, 3), float(number))), number)
    first = path.read_bytes()
    trajectory = Trajectory(stamps_s=np.arange(2.0), T_world_left=poses)
    move_cloud(path, list(poses), trajectory)
    assert path.read_bytes() == first
    moved = poses.copy()
    moved[1, 0, 3] = 5.0
    move_cloud(path, list(poses), Trajectory(stamps_s=np.arange(2.0), T_world_left=moved))
    ((cloud, number),) = read_cloud_chunks(path)
    assert number.tolist() == [0, 0, 1, 1]
    assert cloud.points[:, 0].tolist() == [0.0, 0.0, 6.0, 6.0]
