"""The thesis's controller: the seven steps of section 4.4, with what they need to end."""

import math
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.floor import Array
from recon.exploration.planning import (
    Ways,
    azimuth_of,
    look_along,
    look_at,
    plan,
    stand,
    unexplored,
)
from recon.exploration.sight import Sighting
from recon.exploration.state import State
from recon.exploration.things import Thing
from recon.records import View

STRIDE = 10.0
"""World units between two views on the way into an unexplored direction."""
MAX_TRIES = 3
"""A thing that is still not in the map after so many approaches is noise."""
MEETING_MARGIN = 5.0
"""A sighting's place is wrong by no more than this once it is in the map, world units."""
CHOICE = 5.0
"""Unexplored ground this near to where a heading led is not headed for again."""


@dataclass(slots=True, kw_only=True)
class Circle:
    """The turn round one thing."""

    thing: Thing
    start_rad: float
    """Bearing, from the thing, of the first view."""
    turned_deg: float = 0.0


@dataclass(slots=True, kw_only=True)
class ThesisController:
    """Meets what is new, turns round it, turns on the spot, heads for the unexplored."""

    circle: Circle | None = None
    turned_deg: float = 0.0
    heading: Array | None = None
    finished: list[Thing | Sighting] = field(default_factory=list)
    approached: list[Array] = field(default_factory=list)
    headed_for: list[Array] = field(default_factory=list)
    num_circled: int = 0
    num_skipped: int = 0
    num_barred: int = 0

    def info(self) -> str:
        """Who it is."""
        return "the strategy of the thesis, section 4.4"

    def result(self) -> str:
        """Why it ended."""
        return "nothing reachable" if self.num_barred else "all known"

    def next_view(self, state: State) -> View | None:
        """The first of its activities that has something to do (figures 25 and 26)."""
        ways = plan(state, through_unknown=True)
        for activity in (self._circle, self._meet, self._turn, self._head):
            view = activity(state, ways)
            if view is not None:
                return view
        return None

    def _circle(self, state: State, ways: Ways) -> View | None:
        """Turn round a thing, looking at it all the time (step 4)."""
        circle, step = self.circle, state.settings.exploration.object_turn_deg
        while circle is not None and circle.turned_deg + step < 360.0 - 1e-6:
            circle.turned_deg += step
            circle.thing = _same(circle.thing, state)
            bearing = circle.start_rad - math.radians(circle.turned_deg)
            place = stand(ways, circle.thing, bearing, state.settings.exploration.clearance)
            if place is not None:
                return look_at(ways, place, circle.thing, state)
            self.num_skipped += 1
        if circle is not None:
            self.finished.append(circle.thing)
            self.num_circled += 1
            self.circle, self.turned_deg, self.heading = None, 0.0, None
        return None

    def _meet(self, state: State, ways: Ways) -> View | None:
        """Go to the nearest new thing; begin to turn round it once it is no noise (4 and 6)."""
        seen: list[Thing | Sighting] = [*state.things, *state.sightings]
        new = [t for t in seen if not self._is_finished(t)]
        for thing in sorted(new, key=lambda t: _gap(t, state.place)):
            if isinstance(thing, Thing) and self._is_met(thing, state):
                bearing = azimuth_of(state.place - thing.centre)
                self.circle = Circle(thing=thing, start_rad=bearing)
                return self._circle(state, ways)
            view = self._approach(thing, state, ways)
            if view is not None:
                return view
            self.finished.append(thing)
        return None

    def _is_finished(self, thing: Thing | Sighting) -> bool:
        return any(_gap(done, thing.centre) <= 0.0 for done in self.finished)

    def _is_met(self, thing: Thing, state: State) -> bool:
        """Whether the last view looked at a thing from in front of it."""
        target = state.view.target[[0, 2]]
        near = _gap(thing, state.place) <= 1.5 * state.settings.exploration.clearance
        return near and bool(thing.holds(target[None], MEETING_MARGIN)[0])

    def _approach(self, thing: Thing | Sighting, state: State, ways: Ways) -> View | None:
        """Stand in front of a thing; None where that failed too often or cannot be."""
        before = [other for other in self.approached if np.hypot(*(other - thing.centre)) < CHOICE]
        if len(before) >= MAX_TRIES:
            return None
        self.approached.append(thing.centre)
        bearing = azimuth_of(state.place - thing.centre)
        step = math.radians(state.settings.exploration.object_turn_deg)
        number = math.ceil(math.pi / step)
        for turn in sorted(range(-number, number + 1), key=abs):
            place = stand(ways, thing, bearing + turn * step, state.settings.exploration.clearance)
            if place is not None:
                return look_at(ways, place, thing, state)
        self.num_barred += 1
        return None

    def _turn(self, state: State, ways: Ways) -> View | None:
        """Turn on the spot, counter-clockwise, until it is a whole turn (step 5)."""
        step = state.settings.exploration.robot_turn_deg
        if self.heading is not None or self.turned_deg + step >= 360.0 - 1e-6:
            return None
        self.turned_deg += step
        gaze = state.view.target - state.view.position
        azimuth = azimuth_of(gaze[[0, 2]]) - math.radians(step)
        return look_along(ways, state.place, azimuth, state)

    def _head(self, state: State, ways: Ways) -> View | None:
        """Go into the closest unexplored direction, on and on until something bars the way."""
        if self.heading is None:
            return self._set_out(state, ways)
        ahead = state.place + STRIDE * self.heading
        if ways.is_clear(state.place, ahead):
            return look_along(ways, ahead, azimuth_of(self.heading), state)
        # At the border of the world, or before a thing: look round, then choose again.
        self.heading, self.turned_deg = None, 0.0
        return self._turn(state, ways)

    def _set_out(self, state: State, ways: Ways) -> View | None:
        """Choose a direction; where it is barred at once, go round to its unexplored ground."""
        unknown = state.floor.centres(np.argwhere(unexplored(state.floor, state.things)))
        while (target := self._closest(unknown, state.place)) is not None:
            self.headed_for.append(target)
            direction = (target - state.place) / np.hypot(*(target - state.place))
            ahead = state.place + STRIDE * direction
            if ways.is_clear(state.place, ahead):
                self.heading = direction
                return look_along(ways, ahead, azimuth_of(direction), state)
            place = ways.nearest(target)
            if np.hypot(*(place - state.place)) > 1.0:
                self.turned_deg = 0.0
                return look_along(ways, place, azimuth_of(target - place), state)
            self.num_barred += 1
        return None

    def _closest(self, points_xz: Array, place: Array) -> Array | None:
        """The closest of some points (N, 2), but for those that were headed for before."""
        for target in self.headed_for:
            points_xz = points_xz[np.hypot(*(points_xz - target).T) > CHOICE]
        if not len(points_xz):
            return None
        closest: Array = points_xz[np.hypot(*(points_xz - place).T).argmin()]
        return closest


def _gap(thing: Thing | Sighting, place: Array) -> float:
    """Distance of a place (2,) from the surface of a thing."""
    return float(np.hypot(*(place - thing.centre))) - thing.radius


def _same(thing: Thing, state: State) -> Thing:
    """The thing as the map has it now."""
    return min(
        (other for other in state.things if other.holds(thing.centre[None])[0]),
        key=lambda other: _gap(other, thing.centre),
        default=thing,
    )
