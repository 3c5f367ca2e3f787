"""The frontier controller: a round past all that is left to see, of which the first view is taken.

The round is planned anew after every pair, by what is known then.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array, Mask
from recon.exploration.gains import Visibility
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import ShortestPaths, plan, unexplored
from recon.exploration.scan import Detection, field_of_view
from recon.exploration.sides import Look, Sides, is_known
from recon.exploration.state import State
from recon.exploration.tour import MAX_UNKNOWN, first_stop
from recon.exploration.viewpoints import (
    azimuth_of,
    look_along,
    look_at,
    vantage_points,
    viewpoints_round,
)
from recon.records import View

MAX_WANTED = 24
"""A round goes past no more obstacles: the nearest."""


@dataclass(slots=True, kw_only=True)
class FrontierController:
    """Goes a round of the unknown sides of obstacles and the unknown ground."""

    taken: list[tuple[Array, float]] = field(default_factory=list)
    """Place (2,) and azimuth of every view so far."""
    looks: list[Look] = field(default_factory=list)
    """The obstacles that views were meant to show sides of."""
    reason: str = ""

    def info(self) -> str:
        """Name the strategy."""
        return "a round of new sides of obstacles and unknown ground, by gain against its length"

    def result(self) -> str:
        """Tell why it ended."""
        return self.reason

    def next_view(self, state: State) -> View | None:
        """The first view of the round."""
        gaze = (state.view.target - state.view.position)[[0, 2]]
        self.taken.append((state.place, azimuth_of(gaze)))
        paths, unknown = plan(state), unexplored(state.floor, state.obstacles)
        wanted: list[Obstacle | Detection] = [*state.detections]
        wanted += [obstacle for obstacle in state.obstacles if not is_known(obstacle)]
        view = self._begin(state, paths, _nearest(wanted, state.place), unknown)
        if view is None:
            self._end(wanted, unknown)
        return view

    def _begin(
        self,
        state: State,
        paths: ShortestPaths,
        wanted: Sequence[Obstacle | Detection],
        unknown: Mask,
    ) -> View | None:
        """Plan a round, and begin it."""
        vantage = vantage_points(paths, unknown, state.scales)
        round_them = viewpoints_round(paths, wanted, state)
        places = np.vstack([state.place, vantage, round_them])
        field_rad, exploration = field_of_view(state.pair), state.settings.exploration
        visibility = Visibility.over(state.floor, places, field_rad, exploration.sight_range)
        visibility = visibility.without(self.taken, state.scales.same_place)
        sides = Sides.of(wanted, places, state.floor, field_rad, state.sure_range, self.looks)
        stop = first_stop(paths.length(places), visibility, sides, unknown, state.scales)
        if stop is None:
            return None
        number, azimuth = stop
        self.looks += sides.looks(number, azimuth)
        target = sides.target(number, azimuth)
        if target is None:
            return look_along(paths, places[number], azimuth, state)
        return look_at(paths, places[number], target, state)

    def _end(self, wanted: Sequence[Obstacle | Detection], unknown: Mask) -> None:
        """Note why there is nothing left to do."""
        unseen = [t for t in wanted if isinstance(t, Detection) or not len(t.bearings_rad)]
        is_left = bool(unseen) or unknown.mean() > MAX_UNKNOWN
        self.reason = "nothing reachable" if is_left else "all known"
        barred = len(wanted) - len(unseen)
        if barred:
            self.reason += f"; {barred} obstacles have a side that cannot be reached"


def _nearest(
    wanted: Sequence[Obstacle | Detection], place: Array
) -> Sequence[Obstacle | Detection]:
    """The obstacles that a round may go past."""
    by_distance = sorted(wanted, key=lambda one: float(np.hypot(*(one.centre - place))))
    return by_distance[:MAX_WANTED]
