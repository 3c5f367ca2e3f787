"""Belief: the agent's estimate of its path, from its steps and the objects it saw.

Every pair adds a pose to a graph whose landmarks are the objects; returning to known objects
corrects the whole path.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from recon.exploration.association import NEW, associated
from recon.exploration.floor import Array
from recon.exploration.glances import SURE_CELLS, Field, glance, turned
from recon.exploration.homing import way_home
from recon.exploration.landmarks import Sighter
from recon.exploration.outlines import Outline, outlines
from recon.exploration.rims import rims
from recon.exploration.scales import Scales
from recon.exploration.scan import field_of_view
from recon.exploration.sights import Sight
from recon.exploration.state import State, Walk
from recon.exploration.world_model import WorldModel
from recon.geometry import wrapped
from recon.localisation.graph import Graph
from recon.localisation.links import Link, step_between
from recon.localisation.pairs import Shown, linked
from recon.records import View
from recon.settings import Settings, updated

NUM_NEIGHBOURS, MIN_COSINE = 3, -0.2
"""Earlier pairs that a pair is registered to: those that see an object from less than 100 degrees
off."""
MAX_GLANCES = 8
"""At one place: as many as a look all round takes."""
MAX_RETURNS = 4
"""Times that the agent goes home: a look from there may show that it is not done, or not quite at
home. It stays after the last one."""
NUM_SIGMAS, MAX_CAUTION = 2.0, 1 / 3
"""Standard deviations of the position added to the distance from obstacles; at most this share of
the clearance."""
MOVED, TURNED_RAD = 0.2, math.radians(0.3)
"""Correction of the path, in cells and radians, beyond which the map is rebuilt."""


@dataclass(slots=True, kw_only=True, eq=False)
class Belief:
    """The graph of the walk so far, and its pairs."""

    settings: Settings
    sights: list[Sight] = field(default_factory=list)
    """All pairs, with their poses in the map."""
    graph: Graph | None = None
    _shown: list[Shown] = field(default_factory=list)
    _unclear: dict[int, list[Outline]] = field(default_factory=dict)
    """Sightings that are no known thing yet, by the number of their pair."""
    _glances: list[float] = field(default_factory=list)
    """Headings of those since the agent stands where it stands, radians."""
    _num_returns: int = 0
    _num_turns: int = 0
    """Of the look all round at the start."""
    _again: list[float] = field(default_factory=list)
    """Its headings that are left to look at once more at the end."""

    @property
    def sigma(self) -> float:
        """Standard deviation of the position in its most uncertain direction, world units."""
        if self.graph is None:
            return 0.0
        return float(np.sqrt(np.linalg.eigvalsh(self.graph.covariance()[:2, :2])[-1]))

    @property
    def cautious(self) -> Settings:
        """The settings with the clearance increased by the uncertainty of the position."""
        clearance = self.settings.exploration.walk_clearance
        wide = clearance + min(NUM_SIGMAS * self.sigma, MAX_CAUTION * clearance)
        return updated(self.settings, {"exploration": {"walk_clearance": wide}})

    def correct(self, sight: Sight, model: WorldModel) -> Array:
        """Add the next pair; return the transform (4, 4) from intended to believed pose."""
        meant = sight.planar
        if self.graph is None:
            self.graph = Graph.at(meant, self._step_sigma)
        else:
            self.graph.walk(step_between(self.sights[-1].planar, meant))
        self._shown.append(Shown.of(sight.pair, sight.cloud, self.settings.map))
        self._note(sight, model)
        self.graph.solve()
        self._link()
        self._note_again()
        self.graph.solve()
        return sight.motion(meant, self.graph.poses[-1])

    def _link(self) -> None:
        """Register the last pair to earlier ones that show the same."""
        assert self.graph is not None
        last = len(self._shown) - 1
        links = []
        for number in self._neighbours():
            step = step_between(self.graph.poses[number], self.graph.poses[last])
            spread = self.graph.spread_between(number)
            found = linked(self._shown[number], self._shown[last], step, spread)
            if found is not None:
                links.append(Link(first=number, second=last, step=found[0], information=found[1]))
        self.graph.links += links
        if links:
            self.graph.solve()

    def _neighbours(self) -> list[int]:
        """Numbers of the earlier pairs that see known objects from the most similar directions."""
        assert self.graph is not None
        last = len(self.graph.poses) - 1
        own = {bearing.landmark for bearing in self.graph.bearings if bearing.pose == last}
        apart: dict[int, float] = {}
        for bearing in self.graph.bearings:
            if bearing.pose < last and bearing.landmark in own:
                middle = self.graph.landmarks[bearing.landmark, :2]
                arms = middle - self.graph.poses[[bearing.pose, last], :2]
                lengths = np.hypot(*arms.T)
                cosine = float(arms[0] @ arms[1] / max(lengths.prod(), 1e-9))
                worth = cosine - 0.5 * abs(math.log(max(lengths[0], 1e-6) / max(lengths[1], 1e-6)))
                if cosine > MIN_COSINE:
                    apart[bearing.pose] = max(worth, apart.get(bearing.pose, -9.0))
        best = sorted(apart, key=lambda number: -apart[number])[:NUM_NEIGHBOURS]
        # The previous pair may show the same surface, known or not.
        return best if last - 1 in best or not last else [*best, last - 1]

    def onward(self, asks: Callable[[State], View | None], state: State) -> View | None:
        """The next view that a controller asks for; in the end, the walk back to the first one.

        The sights from there correct the whole path.
        """
        view = asks(state) if self._num_returns < MAX_RETURNS else None
        return view or self._home(state)

    def _home(self, state: State) -> Walk | None:
        """The walk back to the first view; None at home."""
        if self._num_returns >= MAX_RETURNS:
            return None
        self._num_returns += 1
        walk = way_home(self.sights[0].view, state)
        if walk is not None:
            self._again = self._first_headings()
        return walk

    def _first_headings(self) -> list[float]:
        """Headings of the look all round at the start; that which shows most comes last.

        The heading after a look that shows nothing is only as sure as the turn was.
        """
        assert self.graph is not None
        shows = {n: len(self._shown[n].place) for n in range(1, self._num_turns + 1)}
        rows = sorted((n for n in shows if shows[n]), key=lambda n: shows[n])
        return [float(self.graph.poses[row, 2]) for row in rows]

    def keep(self, sight: Sight) -> Sight:
        """Record the pose of the last pair in the map."""
        self.sights.append(sight)
        return sight

    def outdated(self) -> list[Sight] | None:
        """All pairs at their current poses if these differ from the map; otherwise None."""
        assert self.graph is not None
        had = np.array([sight.planar for sight in self.sights]).reshape(-1, 3)
        off = self.graph.poses[: len(had)] - had
        off[:, 2] = wrapped(off[:, 2])
        limit = MOVED * self.settings.map.cell_size
        is_near = (np.hypot(*off.T[:2]) < limit) & (np.abs(off[:, 2]) < TURNED_RAD)
        if is_near.all():
            return None
        self.sights = [
            sight.moved(sight.motion(old, new))
            for sight, old, new in zip(self.sights, had, self.graph.poses, strict=False)
        ]
        return [*self.sights]

    @property
    def _step_sigma(self) -> tuple[float, float]:
        """Of position and heading; never so small that nothing could be corrected."""
        motion, least = self.settings.motion, 1e-4
        return (
            max(motion.position_noise, least * self.settings.map.cell_size),
            max(math.radians(motion.heading_noise_deg), least),
        )

    def _note(self, sight: Sight, model: WorldModel) -> None:
        """Add the sightings of the objects in view, known or new.

        Unclear ones are considered again after the clear ones have corrected the pose, and with
        every later pair, which may correct it as well.
        """
        assert self.graph is not None
        standing = model.standing(sight.view.position[[0, 2]], sight.cloud)
        half_field = field_of_view(sight.pair) / 2.0
        edges = rims(standing, sight.pair)
        seen = outlines(standing, edges, sight.planar, half_field, model.scales)
        number = len(self.graph.poses) - 1
        left = self._noted([one for one in seen if one.is_free.any()], number)
        self.graph.solve()
        left = self._noted(left, number)
        sighter = self._sighter()
        new = [landmark == NEW for landmark in associated(sighter, left)]
        self._unclear[number] = []
        for one, is_new in zip(left, new, strict=True):
            if is_new and one.is_free.all():
                sighter.add(one)
            else:
                self._unclear[number].append(one)

    def _note_again(self) -> None:
        """Add the sightings of earlier pairs that have become clear."""
        for number, left in self._unclear.items():
            self._unclear[number] = self._noted(left, number)

    def _noted(self, seen: list[Outline], number: int) -> list[Outline]:
        """Add the sightings of known objects by a pair; return the others."""
        assert self.graph is not None
        if not seen:
            return []
        sighter, left = self._sighter(number), []
        taken = {bearing.landmark for bearing in self.graph.bearings if bearing.pose == number}
        for one, landmark in zip(seen, associated(sighter, seen), strict=True):
            if landmark < 0 or landmark in taken:
                left.append(one)
            else:
                self.graph.bearings.append(sighter.bearing(one, landmark))
        return left

    def _sighter(self, number: int = -1) -> Sighter:
        assert self.graph is not None
        return Sighter.of(self.graph, self._shown[0].pair.rig.focal_px, number)

    def glance(self) -> View | None:
        """The next view taken only for localisation; None if none is needed.

        It looks all round where it starts, and again when it is back, so that everything in sight
        is tied to the first pose; elsewhere it looks at what it knows, as long as it is not sure of
        its place.
        """
        assert self.graph is not None
        last, scales = self.sights[-1], Scales.of(self.settings)
        half_field = field_of_view(last.pair) / 2.0
        # Each look is a step with its errors: as few as show everything.
        number = math.ceil(math.pi / half_field)
        if self._num_turns < number - 1:
            self._num_turns += 1
            onward = float(self.graph.poses[-1, 2]) + 2.0 * math.pi / number
            return turned(last.view, onward, scales.gaze)
        if self._again:
            return turned(last.view, self._again.pop(0), scales.gaze)
        if len(self._glances) >= MAX_GLANCES:
            self._glances = []
            return None
        heading = glance(
            self._sighter(),
            self._step_sigma,
            Field(half_rad=half_field, reach=self.settings.exploration.sight_range),
            SURE_CELLS * scales.cell,
            scales.viewing_distance,
            self._glances,
        )
        self._glances = [] if heading is None else [*self._glances, heading]
        return None if heading is None else turned(last.view, heading, scales.gaze)


def belief_of(settings: Settings) -> Belief | None:
    """The belief of an agent with motion errors; None if motion is exact."""
    return None if settings.motion.is_exact else Belief(settings=settings)
