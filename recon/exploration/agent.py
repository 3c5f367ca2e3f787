"""The agent: view -> pair -> map -> state -> next view, until a controller or a limit ends it."""

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from recon.errors import InputError, check_finite
from recon.exploration.controllers import Controller, make_controller
from recon.exploration.floor import Array
from recon.exploration.memory import Memory
from recon.exploration.metrics import Record, pairs_until_objects, path_bound
from recon.exploration.state import State, Walk
from recon.mapping import mapper
from recon.mapping.mapper import Mapper
from recon.records import Recognition, Reconstruction, StereoPair, View
from recon.settings import Settings
from recon.stopwatch import Stopwatch
from recon.voxelmap import VoxelMap
from recon.world.world import World

log = logging.getLogger(__name__)

STOP_REASONS = ("all known", "nothing reachable", "limit", "controller failed", "interrupted")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step(mapper.Step):
    """One pair of an exploration."""

    view: View


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exploration:
    """What an exploration left."""

    reconstruction: Reconstruction[VoxelMap]
    recognition: Recognition
    """Of the reconstruction's voxels."""
    clearest: mapper.Step | None
    """The step with most matches."""
    views: tuple[View, ...]
    known_free: Array
    """(K, 2) x, z of the middles of the floor cells known to be free."""
    stop_reason: str
    """One of STOP_REASONS."""
    message: str
    """What the controller said at the end, or why it failed."""
    metrics: dict[str, Any]
    """The numbers of metrics.json, but for `seconds`."""


Take = Callable[[View], StereoPair]
Observe = Callable[[Step], None]


def explore(
    world: World,
    settings: Settings,
    observe: Observe | None = None,
    take: Take | None = None,
    stopwatch: Stopwatch | None = None,
) -> Exploration:
    """Let a controller lead the agent through a world until it ends.

    Parameters
    ----------
    observe : callable, optional
        Called with every `Step`.
    take : callable, optional
        Gives the pair of a view; `world.take` where not given.
    stopwatch : Stopwatch, optional
        Counts the time of the stages `render`, `stereo`, `map`, `plan` and `recognise`.

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
    agent = Agent(world, settings, take or world.take, stopwatch or Stopwatch())
    try:
        for step in agent.steps(controller):
            if observe is not None:
                observe(step)
    except KeyboardInterrupt:
        agent.stop("interrupted", "stopped by the keyboard")
    return agent.exploration()


class Agent:
    """Two eyes that walk; the state of one exploration."""

    def __init__(self, world: World, settings: Settings, take: Take, stopwatch: Stopwatch) -> None:
        self.world = world
        self.settings = settings
        self.take = take
        self.record = Record(world=world, baseline=settings.eyes.baseline)
        self.stopwatch = stopwatch
        self.mapper = Mapper(settings, stopwatch=stopwatch, compares=False)
        self.memory = Memory(settings=settings, voxel_map=self.mapper.voxel_map)
        self.views: list[View] = []
        self.stop_reason = ""
        self.message = ""

    def steps(self, controller: Controller) -> Iterator[Step]:
        """Go from view to view until there is a reason to stop."""
        start = self.world.start()
        self.record.walk(start, start)
        view: View | None = start
        while view is not None:
            try:
                with self.stopwatch.stage("render"):
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
        (mapped,) = self.mapper.process(self._stamped(pair))
        with self.stopwatch.stage("map"):
            self.memory.remember(view, mapped.pair, mapped.cloud)
        with self.stopwatch.stage("recognise"):
            self.memory.name_things()
        self.views.append(view)
        self.record.note(len(self.views), self.memory.floor)
        parts = {part.name: getattr(mapped, part.name) for part in fields(mapped)}
        return Step(**parts, view=view)

    def _stamped(self, pair: StereoPair) -> StereoPair:
        """The pair with a time after the one before; its number where it states none."""
        stamps_s = self.mapper.trajectory.stamps_s
        if not len(stamps_s) or pair.stamp_s > stamps_s[-1]:
            return pair
        return replace(pair, stamp_s=float(len(stamps_s)))

    def _ask(self, controller: Controller, step: Step) -> View | None:
        """The controller's next view, walked to; None where there is a reason to stop."""
        state = self._state(step)
        try:
            with self.stopwatch.stage("plan"):
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
        voxels = self.mapper.voxels()
        recognition = self.mapper.recognise(voxels)
        floor = self.memory.floor
        return Exploration(
            reconstruction=Reconstruction(
                map=self.mapper.voxel_map,
                voxels=voxels,
                objects=recognition.objects,
                trajectory=self.mapper.trajectory,
            ),
            recognition=recognition,
            clearest=self.mapper.clearest,
            views=tuple(self.views),
            known_free=floor.centres(np.argwhere(floor.known_free)),
            stop_reason=self.stop_reason,
            message=self.message,
            metrics=self._metrics(recognition),
        )

    def _metrics(self, recognition: Recognition) -> dict[str, Any]:
        timeline = [*self.memory.timeline, (len(self.views), recognition.objects)]
        reach = self.settings.exploration.viewing_distance
        return {
            "num_pairs": len(self.views),
            "num_points": self.mapper.num_points,
            "num_objects": len(recognition.objects),
            "path_length": self.record.path_length,
            "path_bound": path_bound(self.world.start(), self.world.objects, reach),
            "coverage": self.record.coverage(self.memory.floor),
            "pairs_until_objects": pairs_until_objects(timeline, recognition.objects),
            "min_clearance": self.record.min_clearance,
            "stop_reason": self.stop_reason,
            "curve": [list(point) for point in self.record.curve],
        }


def check_view(view: View) -> None:
    """Raise `InputError` unless a controller's answer is a view of finite numbers."""
    if not isinstance(view, View):
        raise InputError(f"next_view gave {view!r}, but a View or None is needed")
    for name, value in (("position", view.position), ("target", view.target)):
        check_finite(name, value)
    if isinstance(view, Walk):
        check_finite("via", view.via)
