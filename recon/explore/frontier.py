"""The frontier controller: the view that adds most for the way there, until none adds anything."""

import math
from dataclasses import dataclass, field

import numpy as np

from recon.explore.floor import Array, Mask
from recon.explore.gains import Candidates, look_out, new_sides, turn
from recon.explore.planning import (
    GAZE,
    Ways,
    azimuth_of,
    lifted,
    look_to,
    lookouts,
    middle_of,
    plan,
    stand,
    unexplored,
)
from recon.explore.sight import Sighting, field_of_view
from recon.explore.state import State
from recon.explore.things import Thing
from recon.records import UNKNOWN, View

SIDE_AREA = 2000.0
"""A new side of a thing is worth so many cells of unknown ground: a whole look around."""
PAIR_COST = 10.0
"""Taking a pair costs as much as walking this far, world units."""
MUCH_AREA = 1000.0
"""Ground beyond so many cells hardly counts: what lies near is seen first, not what is large."""
MIN_GAIN = 25.0
"""A view that adds fewer cells than this is not worth taking."""
MAX_UNKNOWN = 0.02
"""Share of the floor that may stay unseen in corners when all is called known."""
NUM_BEARINGS = 12
SAME_PLACE, SAME_GAZE_RAD = 3.0, math.radians(20.0)
"""A view nearer than both to an earlier one shows nothing that the earlier one did not."""
SURE = 0.9
"""Probability from which a label is believed."""
OPEN_SURE_RAD, OPEN_RAD = math.radians(110.0), math.radians(80.0)
"""A thing is known when no gap between its views is wider, with a sure label and without."""


@dataclass(slots=True, kw_only=True)
class FrontierController:
    """Weighs what each view adds against the way there."""

    taken: list[tuple[Array, float]] = field(default_factory=list)
    """Place and azimuth of every view so far."""
    reason: str = "all known"

    def info(self) -> str:
        """Who it is."""
        return "frontiers of known ground and new sides of things, by gain against the way"

    def result(self) -> str:
        """Why it ended."""
        return self.reason

    def next_view(self, state: State) -> View | None:
        """The view with the best score, or None where none adds enough."""
        self.taken.append(
            (state.place, azimuth_of((state.view.target - state.view.position)[[0, 2]]))
        )
        ways = plan(state)
        wanted: list[Thing | Sighting] = [*state.sightings]
        wanted += [thing for thing in state.things if not is_known(thing)]
        unknown = unexplored(state.floor, state.things)
        candidates, area = self._candidates(state, ways, wanted, unknown)
        field_rad = field_of_view(state.pair)
        sides = new_sides(
            candidates, wanted, state.floor, field_rad, state.settings.exploration.viewing_distance
        )
        gain = np.where(self._is_taken(candidates), 0.0, area + SIDE_AREA * sides)
        worth = area * MUCH_AREA / (area + MUCH_AREA) + SIDE_AREA * sides
        score = worth / (ways.length(candidates.places) + PAIR_COST)
        best = int(np.where(gain >= MIN_GAIN, score, 0.0).argmax())
        if gain[best] < MIN_GAIN:
            self._end(wanted, unknown)
            return None
        return look_to(ways, candidates.places[best], candidates.targets[best], state)

    def _candidates(
        self, state: State, ways: Ways, wanted: list[Thing | Sighting], unknown: Mask
    ) -> tuple[Candidates, Array]:
        """Views worth weighing, and the unknown cells (C,) that each would show."""
        height = state.settings.eyes.eye_height
        places = np.vstack([state.place, lookouts(ways, unknown)])
        stands = stands_round(ways, wanted, state)
        outlook = look_out(
            state.floor,
            unknown,
            np.vstack([places, stands.places]),
            field_of_view(state.pair),
            state.settings.exploration.sight_range,
        )
        azimuth = outlook.best()[: len(places)]
        ahead = places + GAZE * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
        candidates = Candidates(places=places, targets=lifted(ahead, height)).joined(stands)
        return candidates, outlook.along(candidates.azimuths_rad)

    def _is_taken(self, candidates: Candidates) -> Mask:
        """(C,) which views are as good as one that was taken already."""
        taken = np.zeros(len(candidates.places), dtype=bool)
        for place, azimuth in self.taken:
            is_near = np.hypot(*(candidates.places - place).T) <= SAME_PLACE
            taken |= is_near & (turn(candidates.azimuths_rad, np.array(azimuth)) <= SAME_GAZE_RAD)
        return taken

    def _end(self, wanted: list[Thing | Sighting], unknown: Mask) -> None:
        """Say why there is nothing left to do."""
        unmet = [t for t in wanted if isinstance(t, Sighting) or not len(t.bearings_rad)]
        is_left = bool(unmet) or unknown.mean() > MAX_UNKNOWN
        self.reason = "nothing reachable" if is_left else "all known"
        barred = len(wanted) - len(unmet)
        if barred:
            self.reason += f"; {barred} things have a side that cannot be reached"


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


def stands_round(ways: Ways, wanted: list[Thing | Sighting], state: State) -> Candidates:
    """Places round things that can be reached, each looking at its thing."""
    places, targets = [np.empty((0, 2))], [np.empty((0, 3))]
    clearance = state.settings.exploration.clearance
    for thing in wanted:
        for bearing in np.arange(NUM_BEARINGS) * 2.0 * math.pi / NUM_BEARINGS:
            place = stand(ways, thing, float(bearing), clearance)
            if place is not None:
                places.append(place[None])
                targets.append(middle_of(thing, state)[None])
    return Candidates(places=np.vstack(places), targets=np.vstack(targets))
