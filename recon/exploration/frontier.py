"""The frontier controller: the view that adds most for the path there, until none adds anything."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array, Mask, first_best
from recon.exploration.gains import AZIMUTHS_RAD, Candidates, Visibility, new_sides, ray_of
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import ShortestPaths, plan, unexplored
from recon.exploration.scan import Detection, field_of_view
from recon.exploration.state import State
from recon.exploration.tour import first_stop
from recon.exploration.viewpoints import (
    azimuth_of,
    lifted,
    look_along,
    look_to,
    middle_of,
    vantage_points,
    viewpoint,
)
from recon.records import UNKNOWN, View

MAX_UNKNOWN = 0.02
"""Share of the floor that may stay unseen in corners when all is called known."""
NUM_BEARINGS = 12
SURE = 0.9
"""Probability from which a label is believed."""
OPEN_SURE_RAD, OPEN_RAD = math.radians(130.0), math.radians(100.0)
"""An obstacle is known when no gap between its views is wider, with a sure label and without: three
views or four, from all round."""


@dataclass(slots=True, kw_only=True)
class FrontierController:
    """Looks at obstacles from all round first, then goes a round of the unknown ground."""

    taken: list[tuple[Array, float]] = field(default_factory=list)
    """Place (2,) and azimuth of every view so far."""
    reason: str = ""

    def info(self) -> str:
        """Name the strategy."""
        return "new sides of obstacles and unknown ground, by gain against the path there"

    def result(self) -> str:
        """Tell why it ended."""
        return self.reason

    def next_view(self, state: State) -> View | None:
        """The best look at an obstacle that is not known, or else at unknown ground."""
        gaze = (state.view.target - state.view.position)[[0, 2]]
        self.taken.append((state.place, azimuth_of(gaze)))
        paths, unknown = plan(state), unexplored(state.floor, state.obstacles)
        wanted: list[Obstacle | Detection] = [*state.detections]
        wanted += [obstacle for obstacle in state.obstacles if not is_known(obstacle)]
        viewpoints = viewpoints_round(paths, wanted, state)
        visibility = Visibility.over(
            state.floor,
            np.vstack(
                [state.place, vantage_points(paths, unknown, state.scales), viewpoints.places]
            ),
            field_of_view(state.pair),
            state.settings.exploration.sight_range,
        ).without(self.taken, state.scales.same_place)
        view = look_at_obstacles(state, paths, wanted, viewpoints, visibility, unknown)
        if view is None:
            view = look_at_ground(state, paths, visibility, unknown)
        if view is None:
            self._end(wanted, unknown)
        return view

    def _end(self, wanted: Sequence[Obstacle | Detection], unknown: Mask) -> None:
        """Note why there is nothing left to do."""
        unseen = [t for t in wanted if isinstance(t, Detection) or not len(t.bearings_rad)]
        is_left = bool(unseen) or unknown.mean() > MAX_UNKNOWN
        self.reason = "nothing reachable" if is_left else "all known"
        barred = len(wanted) - len(unseen)
        if barred:
            self.reason += f"; {barred} obstacles have a side that cannot be reached"


def look_at_obstacles(
    state: State,
    paths: ShortestPaths,
    wanted: Sequence[Obstacle | Detection],
    viewpoints: Candidates,
    visibility: Visibility,
    unknown: Mask,
) -> View | None:
    """The view that shows most new sides of obstacles, and ground besides, for the path there."""
    shown = visibility.area(unknown)
    candidates = around(visibility, shown, state).joined(viewpoints)
    row = np.append(np.arange(len(shown)), np.arange(-len(viewpoints.places), 0))
    ray = ray_of(candidates.azimuths_rad)
    reach = state.settings.exploration.viewing_distance
    sides = new_sides(candidates, wanted, state.floor, visibility.field_rad, reach)
    sides[visibility.barred[row, ray]] = 0.0
    if not sides.any():
        return None
    area, scales = shown[row, ray], state.scales
    worth = scales.side_area * sides + scales.much_area * area / (area + scales.much_area)
    score = worth / (paths.length(candidates.places) + scales.pair_cost)
    best = int(first_best(score))
    return look_to(paths, candidates.places[best], candidates.targets[best], state)


def around(visibility: Visibility, shown: Array, state: State) -> Candidates:
    """The level view from each place that shows most unknown ground (C, A)."""
    azimuth = AZIMUTHS_RAD[first_best(shown, axis=1)]
    ahead = visibility.places + state.scales.gaze * np.column_stack(
        [np.cos(azimuth), np.sin(azimuth)]
    )
    return Candidates(places=visibility.places, targets=lifted(ahead, state.scales.eye_height))


def look_at_ground(
    state: State, paths: ShortestPaths, visibility: Visibility, unknown: Mask
) -> View | None:
    """The first view of a round that shows all unknown ground that can be seen."""
    stop = first_stop(state.floor, unknown, visibility, state.place, state.scales)
    if stop is None:
        return None
    place, azimuth = stop
    return look_along(paths, place, azimuth, state)


def is_known(obstacle: Obstacle) -> bool:
    """Whether an obstacle was seen from enough sides for its label and its map."""
    found = obstacle.found
    is_sure = found is not None and found.label != UNKNOWN and (found.probability or 0.0) >= SURE
    return widest_gap(obstacle.bearings_rad) <= (OPEN_SURE_RAD if is_sure else OPEN_RAD)


def widest_gap(bearings_rad: Array) -> float:
    """The widest angle between neighbours among directions (V,); a whole turn for one or none."""
    if not len(bearings_rad):
        return 2.0 * math.pi
    ordered = np.sort(np.mod(bearings_rad, 2.0 * math.pi))
    return float(np.diff(ordered, append=ordered[0] + 2.0 * math.pi).max())


def viewpoints_round(
    paths: ShortestPaths, wanted: Sequence[Obstacle | Detection], state: State
) -> Candidates:
    """Places round obstacles that can be reached, each looking at its obstacle."""
    places, targets = [np.empty((0, 2))], [np.empty((0, 3))]
    clearance = state.scales.clearance
    for obstacle in wanted:
        for bearing in np.linspace(0.0, 2.0 * math.pi, NUM_BEARINGS, endpoint=False):
            place = viewpoint(paths, obstacle, float(bearing), clearance)
            if place is not None:
                places.append(place[None])
                targets.append(middle_of(obstacle, state)[None])
    return Candidates(places=np.vstack(places), targets=np.vstack(targets))
