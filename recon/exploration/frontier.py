"""The frontier controller: plans a round past everything left to see and takes its first view.

The round is planned again after every pair with what is then known.
"""

from dataclasses import dataclass, field

from recon.exploration.doubts import CLOSE, FAR, cut_off, doubtful, doubts, seen_from_afar, strange
from recon.exploration.floor import Array
from recon.exploration.gains import Visibility
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import ShortestPaths, unexplored
from recon.exploration.prospects import Prospects
from recon.exploration.scan import Detection, field_of_view
from recon.exploration.search import Look, Search, Wanted, are_nameable
from recon.exploration.sides import Sides, is_given_up, is_known
from recon.exploration.state import State
from recon.exploration.tour import MAX_UNKNOWN
from recon.exploration.viewpoints import azimuth_of, look_along, look_at
from recon.records import View

HORIZON = 1.5
"""Rounds are planned over the floor within this number of sight ranges if they find a view
there."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Planned:
    """The looks of a view that was asked for."""

    looks: list[Look]
    """The list whose last ones they are."""
    number: int
    num_pairs: int
    """Number of pairs at that time; if it is still the same, something was in the way."""

    def take_back(self) -> None:
        """Forget the looks of a view that was not taken."""
        del self.looks[len(self.looks) - self.number :]


@dataclass(slots=True, kw_only=True)
class FrontierController:
    """Goes on a round of the unknown sides of obstacles and the unknown ground."""

    taken: list[tuple[Array, float]] = field(default_factory=list)
    """Position (2,) and azimuth of every view so far."""
    looks: list[Look] = field(default_factory=list)
    """Views that were meant to show sides of obstacles."""
    second_looks: list[Look] = field(default_factory=list)
    """Views that were meant to remove doubts."""
    far_looks: list[Look] = field(default_factory=list)
    """Views that were meant to show tops."""
    planned: Planned | None = None
    """The looks of the last view asked for."""
    reason: str = ""

    def info(self) -> str:
        """The name of the strategy."""
        return "a round past unseen sides of obstacles and unknown ground, by gain per length"

    def result(self) -> str:
        """The reason why it ended."""
        return self.reason

    def next_view(self, state: State) -> View | None:
        """The first view of the round."""
        if self.planned is not None and self.planned.num_pairs == state.num_pairs:
            self.planned.take_back()
        gaze = (state.view.target - state.view.position)[[0, 2]]
        self.taken.append((state.place, azimuth_of(gaze)))
        reach = HORIZON * state.settings.exploration.sight_range
        near = state.within(reach)
        view = self._once_more(near)
        if view is None:
            view = self._plan(near, self._first(near))
        if view is None and max(state.floor.shape) * state.floor.cell_size > reach:
            view = self._plan(state, self._first(state))
        if view is None:
            view = self._plan(state, self._second(state, doubts(state)))
        if view is None:
            self._end(state)
        return view

    def _first(self, state: State) -> Search:
        return Search(
            wanted=wanted_of(state),
            clearance=state.scales.clearance,
            reach=state.sure_range,
            looks=self.looks,
            expects_names=are_nameable(state.obstacles),
        )

    def _once_more(self, state: State) -> View | None:
        """The next view of obstacles with all sides seen but no sure label; None without any.

        They are viewed again before the agent goes on: it would have to come back.
        """
        known = [one for one in state.obstacles if is_known(one)]
        for search in (
            self._second(state, doubtful(known)),
            self._afar(state, cut_off(known)),
            self._second(state, seen_from_afar(known, state.scales.clearance)),
            self._second(state, strange(known)),
        ):
            if not all(is_given_up(one, search) for one in search.wanted):
                view = self._plan(state, search, needs_sides=True)
                if view is not None:
                    return view
        return None

    def _second(self, state: State, wanted: Wanted) -> Search:
        clearance = CLOSE * state.scales.clearance
        return Search(
            wanted=wanted,
            clearance=clearance,
            reach=clearance,
            looks=self.second_looks,
            max_looks=1,
        )

    def _afar(self, state: State, wanted: Wanted) -> Search:
        clearance = state.scales.clearance
        return Search(
            wanted=wanted,
            clearance=clearance,
            least=FAR * clearance,
            reach=state.sure_range,
            looks=self.far_looks,
            max_looks=1,
        )

    def _plan(self, state: State, search: Search, needs_sides: bool = False) -> View | None:
        """Plan a round and return its first view; if told so, only a round that shows sides."""
        unknown = unexplored(state.floor, state.obstacles)
        wanted = search.nearest(state.place)
        prospects = Prospects.of(state, unknown, wanted, search)
        places = prospects.places
        field_rad, sight_range = field_of_view(state.pair), state.settings.exploration.sight_range
        visibility = Visibility.over(state.floor, places, field_rad, sight_range, unknown)
        visibility = visibility.without(self.taken, state.scales.same_place)
        sides = Sides.of(wanted, places, state.floor, field_rad, search)
        if needs_sides and not sides.shown.any():
            return None
        stop = prospects.first_stop(visibility, sides, unknown, state.scales)
        if stop is None:
            return None
        looks = sides.looks(*stop)
        search.looks.extend(looks)
        self.planned = Planned(looks=search.looks, number=len(looks), num_pairs=state.num_pairs)
        return self._look(state, prospects.known, sides, *stop)

    def _look(
        self, state: State, paths: ShortestPaths, sides: Sides, number: int, azimuth_rad: float
    ) -> View:
        """The view from a position of the round, aimed at an obstacle if one is in its centre."""
        target = sides.target(number, azimuth_rad)
        if target is None:
            return look_along(paths, sides.places[number], azimuth_rad, state)
        return look_at(paths, sides.places[number], target, state)

    def _end(self, state: State) -> None:
        """Record why there is nothing left to do."""
        search, unknown = self._first(state), unexplored(state.floor, state.obstacles)
        wanted = search.wanted
        unseen = [t for t in wanted if isinstance(t, Detection) or not len(t.bearings_rad)]
        doubted = [t for t in unseen if is_given_up(t, search)]
        is_left = len(doubted) < len(unseen) or unknown.mean() > MAX_UNKNOWN
        self.reason = "nothing reachable" if is_left else "all known"
        barred = len(wanted) - len(unseen)
        if barred:
            self.reason += f"; {barred} obstacles have a side that cannot be reached"
        if doubted:
            self.reason += f"; {len(doubted)} detections were not confirmed from nearby"


def wanted_of(state: State) -> list[Obstacle | Detection]:
    """The detections and the obstacles that are not known: everything left to look at."""
    return [*state.detections, *(one for one in state.obstacles if not is_known(one))]
