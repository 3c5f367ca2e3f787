"""The thesis's controller: the seven steps of section 4.4, with rules for termination."""

import math
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import ShortestPaths, plan, unexplored
from recon.exploration.scan import Detection
from recon.exploration.state import State
from recon.exploration.viewpoints import azimuth_of, look_along, look_at, viewpoint
from recon.records import View

MAX_TRIES = 3
"""An obstacle that is still not in the map after this number of approaches is noise."""
NEAR = 0.5
"""Maximum position error of a detection once it is in the map, and distance within which unexplored
ground counts as an earlier target; as a share of the clearance."""


@dataclass(slots=True, kw_only=True)
class Circle:
    """The turn around one obstacle."""

    obstacle: Obstacle
    start_rad: float
    """Bearing, from the obstacle, of the first view."""
    turned_deg: float = 0.0


@dataclass(slots=True, kw_only=True)
class ThesisController:
    """Approaches new obstacles, circles them, turns on the spot, heads for the unexplored."""

    circle: Circle | None = None
    turned_deg: float = 0.0
    heading: Array | None = None
    finished: list[Obstacle | Detection] = field(default_factory=list)
    approached: list[Array] = field(default_factory=list)
    headed_for: list[Array] = field(default_factory=list)
    num_circled: int = 0
    num_skipped: int = 0
    num_barred: int = 0

    def info(self) -> str:
        """The name of the strategy."""
        return "the strategy of the thesis, section 4.4"

    def result(self) -> str:
        """The reason why it ended."""
        return "nothing reachable" if self.num_barred else "all known"

    def next_view(self, state: State) -> View | None:
        """The view of the first activity that has something to do (figures 25 and 26)."""
        paths = plan(state, None)
        for activity in (self._circle, self._meet, self._turn, self._head):
            view = activity(state, paths)
            if view is not None:
                return view
        return None

    def _circle(self, state: State, paths: ShortestPaths) -> View | None:
        """Turn around an obstacle, looking at it all the time (step 4)."""
        circle, step = self.circle, state.settings.exploration.object_turn_deg
        while circle is not None and circle.turned_deg + step < 360.0 - 1e-6:
            circle.turned_deg += step
            circle.obstacle = _same(circle.obstacle, state)
            bearing = circle.start_rad - math.radians(circle.turned_deg)
            place = viewpoint(paths, circle.obstacle, bearing, state.scales.clearance)
            if place is not None:
                return look_at(paths, place, circle.obstacle, state)
            self.num_skipped += 1
        if circle is not None:
            self.finished.append(circle.obstacle)
            self.num_circled += 1
            self.circle, self.turned_deg, self.heading = None, 0.0, None
        return None

    def _meet(self, state: State, paths: ShortestPaths) -> View | None:
        """Go to the nearest new obstacle; circle it once it is not noise (steps 4 and 6)."""
        seen: list[Obstacle | Detection] = [*state.obstacles, *state.detections]
        new = [t for t in seen if not self._is_finished(t)]
        for obstacle in sorted(new, key=lambda t: _gap(t, state.place)):
            if isinstance(obstacle, Obstacle) and self._is_met(obstacle, state):
                bearing = azimuth_of(state.place - obstacle.centre)
                self.circle = Circle(obstacle=obstacle, start_rad=bearing)
                return self._circle(state, paths)
            view = self._approach(obstacle, state, paths)
            if view is not None:
                return view
            self.finished.append(obstacle)
        return None

    def _is_finished(self, obstacle: Obstacle | Detection) -> bool:
        return any(_gap(done, obstacle.centre) <= 0.0 for done in self.finished)

    def _is_met(self, obstacle: Obstacle, state: State) -> bool:
        """True if the last view looked at an obstacle from in front of it."""
        target = state.view.target[[0, 2]]
        near = _gap(obstacle, state.place) <= 1.5 * state.scales.clearance
        return near and bool(obstacle.holds(target[None], NEAR * state.scales.clearance)[0])

    def _approach(
        self, obstacle: Obstacle | Detection, state: State, paths: ShortestPaths
    ) -> View | None:
        """Stand in front of an obstacle; None if that failed too often or is impossible."""
        near = NEAR * state.scales.clearance
        before = [other for other in self.approached if np.hypot(*(other - obstacle.centre)) < near]
        if len(before) >= MAX_TRIES:
            return None
        self.approached.append(obstacle.centre)
        bearing = azimuth_of(state.place - obstacle.centre)
        step = math.radians(state.settings.exploration.object_turn_deg)
        number = math.ceil(math.pi / step)
        for turn in sorted(range(-number, number + 1), key=abs):
            place = viewpoint(paths, obstacle, bearing + turn * step, state.scales.clearance)
            if place is not None:
                return look_at(paths, place, obstacle, state)
        self.num_barred += 1
        return None

    def _turn(self, state: State, paths: ShortestPaths) -> View | None:
        """Turn on the spot, counter-clockwise, up to a full turn (step 5)."""
        step = state.settings.exploration.robot_turn_deg
        if self.heading is not None or self.turned_deg + step >= 360.0 - 1e-6:
            return None
        self.turned_deg += step
        gaze = state.view.target - state.view.position
        azimuth = azimuth_of(gaze[[0, 2]]) - math.radians(step)
        return look_along(paths, state.place, azimuth, state)

    def _head(self, state: State, paths: ShortestPaths) -> View | None:
        """Go in the closest unexplored direction until something blocks the path."""
        if self.heading is None:
            return self._set_out(state, paths)
        ahead = state.place + state.scales.clearance * self.heading
        if paths.is_clear(state.place, ahead):
            return look_along(paths, ahead, azimuth_of(self.heading), state)
        # At the border of the world or an obstacle: look around, then choose again.
        self.heading, self.turned_deg = None, 0.0
        return self._turn(state, paths)

    def _set_out(self, state: State, paths: ShortestPaths) -> View | None:
        """Choose a direction; if it is blocked, go around to its unexplored ground."""
        unknown = state.floor.centres(np.argwhere(unexplored(state.floor, state.obstacles)))
        while (target := self._closest(unknown, state)) is not None:
            self.headed_for.append(target)
            direction = (target - state.place) / np.hypot(*(target - state.place))
            ahead = state.place + state.scales.clearance * direction
            if paths.is_clear(state.place, ahead):
                self.heading = direction
                return look_along(paths, ahead, azimuth_of(direction), state)
            place = paths.nearest(target)
            if np.hypot(*(place - state.place)) > state.scales.cell:
                self.turned_deg = 0.0
                return look_along(paths, place, azimuth_of(target - place), state)
            self.num_barred += 1
        return None

    def _closest(self, points_xz: Array, state: State) -> Array | None:
        """The closest of some points (N, 2), except earlier targets."""
        for target in self.headed_for:
            points_xz = points_xz[np.hypot(*(points_xz - target).T) > NEAR * state.scales.clearance]
        if not len(points_xz):
            return None
        closest: Array = points_xz[np.hypot(*(points_xz - state.place).T).argmin()]
        return closest


def _gap(obstacle: Obstacle | Detection, place: Array) -> float:
    """Distance of a position (2,) from the surface of an obstacle."""
    return float(np.hypot(*(place - obstacle.centre))) - obstacle.radius


def _same(obstacle: Obstacle, state: State) -> Obstacle:
    """The obstacle as it is in the map now."""
    return min(
        (other for other in state.obstacles if other.holds(obstacle.centre[None])[0]),
        key=lambda other: _gap(other, obstacle.centre),
        default=obstacle,
    )
