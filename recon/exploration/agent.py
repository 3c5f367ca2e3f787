"""The agent: view -> pair -> map -> state -> next view, until a controller or a limit ends it."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from recon.errors import InputError, check_finite
from recon.exploration.controllers import Controller, make_controller
from recon.exploration.floor import Array
from recon.exploration.memory import Memory
from recon.exploration.metrics import Record, pairs_until_objects, path_bound
from recon.exploration.state import State, Walk
from recon.mapping.pair import process_pair
from recon.recognition import recognise
from recon.records import Matches, PointCloud, Recognition, StereoPair, View
from recon.settings import Settings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import new_map, occupied
from recon.world.world import World

log = logging.getLogger(__name__)

STOP_REASONS = ("all known", "nothing reachable", "limit", "controller failed", "interrupted")
STAGES = ("render", "stereo", "map", "plan", "recognise")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """One pair of an exploration."""

    number: int
    """0, 1, ..."""
    view: View
    pair: StereoPair
    matches: Matches
    cloud: PointCloud
    """World."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exploration:
    """What an exploration left."""

    voxel_map: VoxelMap
    recognition: Recognition
    trajectory: Array
    """(N, 4, 4) T_world_left, one a pair."""
    stamps_s: Array
    """(N,)"""
    views: tuple[View, ...]
    known_free: Array
    """(K, 2) x, z of the middles of the floor cells known to be free."""
    stop_reason: str
    """One of STOP_REASONS."""
    message: str
    """What the controller said at the end, or why it failed."""
    metrics: dict[str, Any]
    """The numbers of metrics.json, but for `seconds`."""
    seconds: dict[str, float]
    """Wall time by stage."""


Take = Callable[[View], StereoPair]
Observe = Callable[[Step], None]


def explore(
    world: World,
    settings: Settings,
    observe: Observe | None = None,
    take: Take | None = None,
) -> Exploration:
    """Let a controller lead the agent through a world until it ends.

    Parameters
    ----------
    observe : callable, optional
        Called with every `Step`.
    take : callable, optional
        Gives the pair of a view; `world.take` where not given.

    Returns
    -------
    Exploration
        Whole whatever ended it, a failing controller and Ctrl-C included.

    Raises
    ------
    InputError
        For an unknown controller.
    """
    controller = make_controller(settings.exploration.controller)
    agent = Agent(world, settings, take or world.take)
    try:
        for step in agent.steps(controller):
            if observe is not None:
                observe(step)
    except KeyboardInterrupt:
        agent.stop("interrupted", "stopped by the keyboard")
    return agent.exploration()


class Agent:
    """Two eyes that walk; the state of one exploration."""

    def __init__(self, world: World, settings: Settings, take: Take) -> None:
        self.world = world
        self.settings = settings
        self.take = take
        self.record = Record(world=world, baseline=settings.eyes.baseline)
        self.memory = Memory(settings=settings, voxel_map=new_map(settings.map))
        self.views: list[View] = []
        self.poses: list[Array] = []
        self.stamps_s: list[float] = []
        self.num_points = 0
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self.stop_reason = ""
        self.message = ""

    def steps(self, controller: Controller) -> Iterator[Step]:
        """Go from view to view until there is a reason to stop."""
        start = self.world.start()
        self.record.walk(start, start)
        view: View | None = start
        while view is not None:
            try:
                with self._timed("render"):
                    pair = self.take(view)
            except InputError as error:
                return self.stop("controller failed", f"its view cannot be taken: {error}")
            step = self._look(view, pair)
            yield step
            if len(self.views) >= self.settings.exploration.max_pairs:
                return self.stop("limit", f"{len(self.views)} pairs are taken")
            view = self._ask(controller, step)
        return None

    def stop(self, reason: str, message: str) -> None:
        """Note why the exploration ended."""
        self.stop_reason, self.message = reason, message
        level = logging.WARNING if reason == "controller failed" else logging.INFO
        log.log(level, "%s: %s", reason, message)

    def _look(self, view: View, pair: StereoPair) -> Step:
        """Put a pair into the map and the memory."""
        number = len(self.views)
        result = process_pair(pair, self.settings, self.memory.voxel_map, number)
        self.seconds["stereo"] += result.stereo_s
        self.seconds["map"] += result.map_s
        with self._timed("map"):
            self.memory.remember(view, pair, result.cloud)
        with self._timed("recognise"):
            self.memory.name_things()
        self._note(view, pair, result.cloud)
        return Step(number=number, view=view, pair=pair, matches=result.matches, cloud=result.cloud)

    def _note(self, view: View, pair: StereoPair, cloud: PointCloud) -> None:
        """Keep what the metrics are made of."""
        self.views.append(view)
        self.poses.append(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
        self.stamps_s.append(pair.stamp_s)
        self.num_points += len(cloud)
        self.record.note(len(self.views), self.memory.floor)

    def _ask(self, controller: Controller, step: Step) -> View | None:
        """The controller's next view, walked to; None where there is a reason to stop."""
        state = self._state(step)
        try:
            with self._timed("plan"):
                view = controller.next_view(state)
            if view is None:
                said = controller.result()
                reason = said.partition(";")[0]
                self.stop(reason if reason in STOP_REASONS else "all known", said)
                return None
            check_view(view)
        # A plug-in may raise anything; what was explored till then is kept.
        except Exception as error:
            log.debug("the controller failed", exc_info=True)
            self.stop("controller failed", f"{type(error).__name__}: {error}")
            return None
        return view if self._walk(step.view, view) else None

    def _walk(self, start: View, end: View) -> bool:
        """Go to a view; whether nothing stood in the way."""
        if self.record.walk(start, end):
            return True
        if self.world.is_inside(start.position[None])[0]:
            self.stop("nothing reachable", "the agent stands inside an object")
        else:
            x, _, z = end.position
            self.stop("controller failed", f"the way to x {x:.2f}, z {z:.2f} runs into an object")
        return False

    def _state(self, step: Step) -> State:
        return State(
            num_pairs=len(self.views),
            view=step.view,
            pair=step.pair,
            voxel_map=self.memory.voxel_map,
            floor=self.memory.floor,
            things=self.memory.things,
            sightings=self.memory.sightings,
            objects=self.memory.objects,
            simulator=self.world,
            settings=self.settings,
        )

    def exploration(self) -> Exploration:
        """All that there is, whatever ended it."""
        voxels = occupied(self.memory.voxel_map, self.settings.map)
        with self._timed("recognise"):
            recognition = recognise(voxels, self.settings.recognition)
        floor = self.memory.floor
        return Exploration(
            voxel_map=self.memory.voxel_map,
            recognition=recognition,
            trajectory=np.array(self.poses).reshape(-1, 4, 4),
            stamps_s=np.array(self.stamps_s),
            views=tuple(self.views),
            known_free=floor.centres(np.argwhere(floor.known_free)),
            stop_reason=self.stop_reason,
            message=self.message,
            metrics=self._metrics(recognition),
            seconds=self.seconds,
        )

    def _metrics(self, recognition: Recognition) -> dict[str, Any]:
        timeline = [*self.memory.timeline, (len(self.views), recognition.objects)]
        reach = self.settings.exploration.viewing_distance
        return {
            "num_pairs": len(self.views),
            "num_points": self.num_points,
            "num_objects": len(recognition.objects),
            "path_length": self.record.path_length,
            "path_bound": path_bound(self.world.start(), self.world.objects, reach),
            "coverage": self.record.coverage(self.memory.floor),
            "pairs_until_objects": pairs_until_objects(timeline, recognition.objects),
            "min_clearance": self.record.min_clearance,
            "stop_reason": self.stop_reason,
            "curve": [list(point) for point in self.record.curve],
        }

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.seconds[stage] += time.perf_counter() - began


def check_view(view: View) -> None:
    """Raise `InputError` unless a controller's answer is a view of finite numbers."""
    if not isinstance(view, View):
        raise InputError(f"next_view gave {view!r}, but a View or None is needed")
    for name, value in (("position", view.position), ("target", view.target)):
        check_finite(name, value)
    if isinstance(view, Walk):
        check_finite("via", view.via)
