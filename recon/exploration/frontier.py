"""The frontier controller: what adds most for the way there, until nothing adds anything."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array, Mask
from recon.exploration.gains import AZIMUTHS_RAD, Candidates, Outlook, new_sides, ray_of
from recon.exploration.planning import (
    GAZE,
    Ways,
    azimuth_of,
    lifted,
    look_along,
    look_to,
    lookouts,
    middle_of,
    plan,
    stand,
    unexplored,
)
from recon.exploration.sight import Sighting, field_of_view
from recon.exploration.state import State
from recon.exploration.things import Thing
from recon.exploration.tour import first_stop
from recon.records import UNKNOWN, View

SIDE_AREA = 2000.0
"""A new side of a thing is worth so many cells of unknown ground."""
MUCH_AREA = 300.0
"""Ground beyond so many cells hardly counts while there are things to look at."""
PAIR_COST = 10.0
"""Taking a pair costs as much as walking this far, world units."""
MAX_UNKNOWN = 0.02
"""Share of the floor that may stay unseen in corners when all is called known."""
NUM_BEARINGS = 12
SURE = 0.9
"""Probability from which a label is believed."""
OPEN_SURE_RAD, OPEN_RAD = math.radians(130.0), math.radians(100.0)
"""A thing is known when no gap between its views is wider, with a sure label and without: three
views or four, from all round."""


@dataclass(slots=True, kw_only=True)
class FrontierController:
    """Looks at things from all round first, then goes a round of the unknown ground."""

    taken: list[tuple[Array, float]] = field(default_factory=list)
    """Place (2,) and azimuth of every view so far."""
    reason: str = ""

    def info(self) -> str:
        """Who it is."""
        return "new sides of things and unknown ground, by what a view adds against the way there"

    def result(self) -> str:
        """Why it ended."""
        return self.reason

    def next_view(self, state: State) -> View | None:
        """The best look at a thing that is not known, or else at unknown ground."""
        gaze = (state.view.target - state.view.position)[[0, 2]]
        self.taken.append((state.place, azimuth_of(gaze)))
        ways, unknown = plan(state), unexplored(state.floor, state.things)
        wanted: list[Thing | Sighting] = [*state.sightings]
        wanted += [thing for thing in state.things if not is_known(thing)]
        stands = stands_round(ways, wanted, state)
        outlook = Outlook.over(
            state.floor,
            np.vstack([state.place, lookouts(ways, unknown), stands.places]),
            field_of_view(state.pair),
            state.settings.exploration.sight_range,
        ).without(self.taken)
        view = look_at_things(state, ways, wanted, stands, outlook, unknown)
        if view is None:
            view = look_at_ground(state, ways, outlook, unknown)
        if view is None:
            self._end(wanted, unknown)
        return view

    def _end(self, wanted: Sequence[Thing | Sighting], unknown: Mask) -> None:
        """Say why there is nothing left to do."""
        unseen = [t for t in wanted if isinstance(t, Sighting) or not len(t.bearings_rad)]
        is_left = bool(unseen) or unknown.mean() > MAX_UNKNOWN
        self.reason = "nothing reachable" if is_left else "all known"
        barred = len(wanted) - len(unseen)
        if barred:
            self.reason += f"; {barred} things have a side that cannot be reached"


def look_at_things(
    state: State,
    ways: Ways,
    wanted: Sequence[Thing | Sighting],
    stands: Candidates,
    outlook: Outlook,
    unknown: Mask,
) -> View | None:
    """The view that shows most new sides of things, and ground besides, for the way there."""
    cells = outlook.cells(unknown)
    candidates = around(outlook, cells, state).joined(stands)
    row = np.append(np.arange(len(cells)), np.arange(-len(stands.places), 0))
    ray = ray_of(candidates.azimuths_rad)
    reach = state.settings.exploration.viewing_distance
    sides = new_sides(candidates, wanted, state.floor, outlook.field_rad, reach)
    sides[outlook.barred[row, ray]] = 0.0
    if not sides.any():
        return None
    area = cells[row, ray]
    worth = SIDE_AREA * sides + MUCH_AREA * area / (area + MUCH_AREA)
    score = worth / (ways.length(candidates.places) + PAIR_COST)
    best = int(score.argmax())
    return look_to(ways, candidates.places[best], candidates.targets[best], state)


def around(outlook: Outlook, cells: Array, state: State) -> Candidates:
    """From each place the level view that shows most unknown cells (C, A)."""
    azimuth = AZIMUTHS_RAD[cells.argmax(axis=1)]
    ahead = outlook.places + GAZE * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    return Candidates(places=outlook.places, targets=lifted(ahead, state.settings.eyes.eye_height))


def look_at_ground(state: State, ways: Ways, outlook: Outlook, unknown: Mask) -> View | None:
    """The first view of a round that shows all unknown ground that can be seen."""
    stop = first_stop(state.floor, unknown, outlook, state.place)
    if stop is None:
        return None
    place, azimuth = stop
    return look_along(ways, place, azimuth, state)


def is_known(thing: Thing) -> bool:
    """Whether a thing was seen from enough sides for its label and its map."""
    found = thing.found
    is_sure = found is not None and found.label != UNKNOWN and found.probability >= SURE
    return widest_gap(thing.bearings_rad) <= (OPEN_SURE_RAD if is_sure else OPEN_RAD)


def widest_gap(bearings_rad: Array) -> float:
    """The widest angle between neighbours among directions (V,); a whole turn for one or none."""
    if not len(bearings_rad):
        return 2.0 * math.pi
    ordered = np.sort(np.mod(bearings_rad, 2.0 * math.pi))
    return float(np.diff(ordered, append=ordered[0] + 2.0 * math.pi).max())


def stands_round(ways: Ways, wanted: Sequence[Thing | Sighting], state: State) -> Candidates:
    """Places round things that can be reached, each looking at its thing."""
    places, targets = [np.empty((0, 2))], [np.empty((0, 3))]
    clearance = state.settings.exploration.clearance
    for thing in wanted:
        for bearing in np.linspace(0.0, 2.0 * math.pi, NUM_BEARINGS, endpoint=False):
            place = stand(ways, thing, float(bearing), clearance)
            if place is not None:
                places.append(place[None])
                targets.append(middle_of(thing, state)[None])
    return Candidates(places=np.vstack(places), targets=np.vstack(targets))
