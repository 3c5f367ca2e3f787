"""The exploration loop and both controllers, in worlds of cylinders."""

import numpy as np
import pytest

from recon.errors import InputError
from recon.exploration.floor import Floor
from recon.records import View

TREES = [(20.0, 12.0, 4.0, 14.0), (-25.0, 8.0, 6.0, 12.0), (5.0, -30.0, 3.0, 10.0)]


def is_found(exploration, disc):
    """Check that the map has an object centred within one unit of a cylinder's axis."""
    x, z, radius, _ = disc
    cells_xz = exploration.reconstruction.voxels.means[:, [0, 2]]
    near = cells_xz[np.hypot(*(cells_xz - [x, z]).T) < radius + 2.0]
    if not len(near):
        return False
    middle = (near.min(axis=0) + near.max(axis=0)) / 2
    return bool(np.hypot(*(middle - [x, z])) < 1.0)


def positions(exploration):
    return exploration.reconstruction.trajectory.positions


@pytest.mark.parametrize("controller", ["frontier", "thesis"])
def test_controller_ends_when_all_objects_and_the_floor_are_known(explore_discs, controller):
    done = explore_discs(TREES, controller=controller)
    assert done.stop_reason == "all known"
    assert all(is_found(done, disc) for disc in TREES)
    assert 0.97 < done.metrics["coverage"] <= 1.0
    assert done.metrics["min_clearance"] > 1.0
    assert done.metrics["path_bound"] <= done.metrics["path_length"]


def test_frontier_controller_walks_less_than_the_thesis(explore_discs):
    """In the mean over mirror images of a world: by the luck of one, .7 to 1.1 times as far."""
    path, pairs = [], []
    for along, across in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        trees = [(along * x, across * z, *size) for x, z, *size in TREES]
        frontier = explore_discs(trees, controller="frontier").metrics
        thesis = explore_discs(trees, controller="thesis").metrics
        assert frontier["coverage"] >= 0.98 * thesis["coverage"]
        path.append(frontier["path_length"] / thesis["path_length"])
        pairs.append(frontier["num_pairs"] / thesis["num_pairs"])
    assert np.mean(path) <= 1.0
    assert np.mean(pairs) <= 0.65


def test_metrics_trajectory_and_curve_are_consistent(explore_discs):
    done = explore_discs(TREES)
    metrics = done.metrics
    assert metrics["num_pairs"] == len(done.views) == len(done.reconstruction.trajectory)
    assert metrics["curve"][-1] == [
        metrics["num_pairs"], metrics["path_length"], metrics["coverage"],
    ]  # fmt: skip
    assert all(np.diff([point[1] for point in metrics["curve"]]) >= 0)
    assert all(np.diff([point[2] for point in metrics["curve"]]) >= 0)
    assert 1 <= metrics["pairs_until_objects"] <= metrics["num_pairs"]
    straight = np.linalg.norm(np.diff([v.position for v in done.views], axis=0), axis=1).sum()
    assert straight - 1e-9 <= metrics["path_length"] <= 1.5 * straight
    eyes = done.reconstruction.trajectory.positions - [view.position for view in done.views]
    assert np.allclose(np.linalg.norm(eyes, axis=1), 0.15)


def test_exploration_is_reproducible_and_resumes_from_saved_pairs(explore_discs):
    saved = []
    first, second = explore_discs(TREES), explore_discs(TREES, observe=lambda s: saved.append(s))
    assert np.array_equal(positions(first), positions(second))
    assert first.metrics == second.metrics
    pairs = [step.pair for step in saved[:12]]
    again = explore_discs(TREES, take=lambda view: pairs.pop(0), max_pairs=12)
    assert pairs == []
    assert np.array_equal(positions(first)[:12], positions(again))


def test_ctrl_c_gives_a_complete_exploration(explore_discs):
    def observe(step):
        if step.number == 4:
            raise KeyboardInterrupt

    done = explore_discs(TREES, observe=observe)
    assert done.stop_reason == done.metrics["stop_reason"] == "interrupted"
    assert len(done.views) == 5
    assert done.reconstruction.map.num_cells > 0


def test_ctrl_c_before_the_first_pair_gives_an_empty_exploration(explore_discs):
    def take(view):
        raise KeyboardInterrupt

    done = explore_discs(TREES, take=take)
    assert done.stop_reason == "interrupted"
    assert done.metrics["num_pairs"] == done.metrics["num_points"] == len(positions(done)) == 0


@pytest.mark.parametrize("controller", ["frontier", "thesis"])
def test_empty_world_is_explored_quickly(explore_discs, controller):
    done = explore_discs([], controller=controller, size=80.0)
    assert done.stop_reason == "all known"
    assert done.metrics["num_objects"] == done.metrics["pairs_until_objects"] == 0
    assert done.metrics["coverage"] > 0.97
    assert done.metrics["num_pairs"] < 60


@pytest.mark.parametrize("controller", ["frontier", "thesis"])
def test_start_inside_an_object_is_rejected(explore_discs, controller):
    with pytest.raises(InputError, match=r"exploration\.start_position: x 0, z 0 .*inside"):
        explore_discs([(0.0, 0.0, 4.0, 12.0)], controller=controller)


def test_enclosed_start_ends_with_nothing_reachable(explore_discs):
    angles = np.arange(16) * 2 * np.pi / 16
    wall = [(14 * np.cos(a), 14 * np.sin(a), 3.2, 12.0) for a in angles]
    done = explore_discs([*wall, (30.0, 30.0, 4.0, 12.0)], size=80.0)
    assert done.stop_reason == "nothing reachable"
    assert done.metrics["min_clearance"] > 1.0
    assert done.metrics["coverage"] < 0.3


@pytest.mark.parametrize("controller", ["frontier", "thesis"])
def test_invisible_obstacle_is_avoided_after_contact(explore_discs, controller, monkeypatch):
    touches, touch = [], Floor.touch
    monkeypatch.setattr(Floor, "touch", lambda *args: touches.append(args[1]) or touch(*args))
    done = explore_discs(
        [(30.0, 0.0, 4.0, 12.0)], controller=controller, glass=[(14.0, 0.0, 4.0, 12.0)], size=80.0
    )
    assert done.stop_reason == "all known", done.message
    assert np.hypot(*(touches[0] - [14.0, 0.0])) == pytest.approx(4.5, abs=0.1)
    assert done.metrics["min_clearance"] >= 0.5
    assert is_found(done, (30.0, 0.0, 4.0, 12.0))


def test_touching_objects_are_circled_together(explore_discs):
    done = explore_discs([(16.0, 0.0, 5.0, 12.0), (25.0, 2.0, 5.0, 9.0)], size=80.0)
    assert done.stop_reason == "all known"
    assert done.metrics["min_clearance"] > 1.0
    assert done.metrics["coverage"] > 0.97


def test_obstacle_at_the_border_is_seen_from_reachable_places(explore_discs):
    done = explore_discs([(35.0, 0.0, 6.0, 12.0)], size=80.0)
    assert done.stop_reason == "all known"
    assert "cannot be reached" in done.message
    assert len(done.recognition.objects) >= 1


def test_every_separate_cylinder_is_one_object(explore_discs):
    assert len(explore_discs(TREES).recognition.objects) == len(TREES)


class FaultyController:
    """A controller that takes one valid view, then fails."""

    def __init__(self, answer):
        self.answer = answer

    def next_view(self, state):
        if state.num_pairs == 1:
            return View(position=np.array([0, 5.0, 0]), target=np.array([9.0, 5, 0]))
        return self.answer()

    def info(self):
        return "wrong"

    def result(self):
        return "seen enough"


def raise_error():
    raise ZeroDivisionError("no plan")


FAULTS = {
    "ZeroDivisionError: no plan": raise_error,
    "position holds nan": lambda: View(position=[np.nan, 5, 0], target=[0, 5, 1]),
    "a View or None is needed": lambda: "left",
    "runs into an object": lambda: View(position=[20, 5, 12], target=[0, 5, 1]),
    "no horizontal direction": lambda: View(position=[0, 5, 0], target=[0, 9, 0]),
    "focal_length is": lambda: View(
        position=[0, 5, 0], target=[1, 9, 0], focal_length=1, fov_deg=9
    ),
}


@pytest.mark.parametrize("message", FAULTS)
def test_failing_controller_gives_a_complete_exploration(explore_discs, message):
    done = explore_discs(TREES, led_by=FaultyController(FAULTS[message]))
    assert done.stop_reason == "controller failed"
    assert message in done.message
    assert len(done.views) == 2
    assert np.isfinite(done.metrics["min_clearance"])


class AvoidingController(FaultyController):
    """A controller that avoids what its path collides with."""

    def next_view(self, state):
        x = -20 if state.floor.touched.any() else 5
        return None if state.num_pairs > 3 else View(position=[x, 5, -30], target=[0, 5, 1])


def test_controller_is_asked_again_after_a_collision(explore_discs):
    done = explore_discs(TREES, led_by=AvoidingController(None))
    assert done.stop_reason == "controller ended"
    assert [view.position[0] for view in done.views] == [0, -20, -20, -20]
    assert done.metrics["path_length"] == pytest.approx(np.hypot(20, 30))


def test_controller_that_never_ends_is_stopped(explore_discs):
    turning = FaultyController(lambda: View(position=[0, 5, 0], target=[0, 5, 1]))
    done = explore_discs(TREES, led_by=turning, max_pairs=7)
    assert done.stop_reason == "limit"
    assert len(done.views) == 7


def test_custom_message_of_a_controller_is_kept(explore_discs):
    done = explore_discs(TREES, led_by=FaultyController(lambda: None))
    assert (done.stop_reason, done.message) == ("controller ended", "seen enough")
