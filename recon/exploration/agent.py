"""The agent: view -> pair -> map -> state -> next view, until the controller or a limit ends it."""

import logging
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exploration.belief import belief_of
from recon.exploration.controllers import Controller, check_view, make_controller, result_of
from recon.exploration.explorable import Explorable, start_of
from recon.exploration.floor import Array, check_floor
from recon.exploration.focus import focusable, focusing
from recon.exploration.metrics import length_of, pairs_until_objects, path_between
from recon.exploration.outcome import STOP_REASONS, Exploration, Step
from recon.exploration.referee import referee_of
from recon.exploration.sights import Sight
from recon.exploration.slip import slip_of
from recon.exploration.state import State
from recon.exploration.world_model import WorldModel
from recon.mapping import mapper
from recon.mapping.mapper import Mapper
from recon.mapping.pair import match_points
from recon.records import Recognition, Reconstruction, StereoPair, View
from recon.settings import Settings
from recon.stopwatch import Stopwatch

log = logging.getLogger(__name__)

Take = Callable[[View], StereoPair]
Observe = Callable[[Step], None]


def explore(
    source: Explorable,
    settings: Settings,
    observe: Observe | None = None,
    take: Take | None = None,
    stopwatch: Stopwatch | None = None,
    controller: Controller | None = None,
) -> Exploration:
    """Let a controller guide the agent through a world until it ends.

    Parameters
    ----------
    source : Explorable
        The world to explore: a simulated world, or anything with `start()` and `take(view)`.
    observe : callable, optional
        Called with every `Step`.
    take : callable, optional
        Returns the pair of a view; `source.take` by default.
    stopwatch : Stopwatch, optional
        Measures the stages `render`, `stereo`, `map`, `plan` and `recognise`.
    controller : Controller, optional
        The controller; `exploration.controller` of the settings by default.

    Returns
    -------
    Exploration
        Complete whatever ended it, including a failing controller or Ctrl-C.

    Raises
    ------
    InputError
        For an unknown controller, a floor with too many cells, or a blocked start.
    """
    check_floor(settings)
    controller = controller or make_controller(settings.exploration.controller)
    take = focusing(take or source.take, settings)
    agent = Agent(source, focusable(settings), take, stopwatch or Stopwatch())
    try:
        for step in agent.steps(controller):
            if observe is not None:
                observe(step)
    except KeyboardInterrupt:
        agent.stop("interrupted", "stopped by the keyboard")
    return agent.exploration()


class Agent:
    """Two walking cameras; the state of one exploration."""

    def __init__(
        self, source: Explorable, settings: Settings, take: Take, stopwatch: Stopwatch
    ) -> None:
        self.settings, self.take = settings, take
        self.referee = referee_of(source, settings)
        self.slip = slip_of(self.referee, settings)
        self.belief = belief_of(settings)
        self.stopwatch = stopwatch
        self._begin()
        self.start = start_of(source, settings)
        self._check_start()
        self.views: list[View] = []
        self.path_length = 0.0
        self.curve: list[tuple[int, float, float | None]] = []
        self.stop_reason, self.message = "", ""

    def _begin(self) -> None:
        """Start with an empty map and model."""
        self.mapper = Mapper(self.settings, stopwatch=self.stopwatch, compares=False)
        self.model = WorldModel(settings=self.settings, voxel_map=self.mapper.voxel_map)

    def steps(self, controller: Controller) -> Iterator[Step]:
        """Go from view to view until there is a reason to stop."""
        view: View | None = self.start
        while view is not None:
            try:
                with self.stopwatch.stage("render"):
                    pair = self._taken(view)
            except InputError as error:
                return self.stop("controller failed", f"its view cannot be taken: {error}")
            step = replace(self._look(view, pair), said=result_of(controller))
            yield step
            if len(self.views) >= self.settings.exploration.max_pairs:
                return self.stop("limit", f"{len(self.views)} pairs are taken")
            view = self._glance(step) or self._ask(controller, step)
        return None

    def _glance(self, step: Step) -> View | None:
        """A view taken only for localisation, already turned to; None if none is needed."""
        view = None if self.belief is None else self.belief.glance()
        return view if view and self._walk(step.view, view) is None else None

    def _taken(self, view: View) -> StereoPair:
        """The pair of a view from the agent's true pose, with its believed pose."""
        if self.slip is None:
            return self.take(view)
        return self.slip.as_believed(self.take(self.slip.true_view(view)))

    def stop(self, reason: str, message: str) -> None:
        """Record why the exploration ended."""
        self.stop_reason, self.message = reason, message
        log.info("%s: %s", reason, message)

    def _check_start(self) -> None:
        """Raise `InputError` if the agent cannot start."""
        x, _, z = self.start.position
        if not self.model.floor.holds(self.model.floor.cells([x, z])):
            raise InputError(
                f"exploration.start_position: x {x:g}, z {z:g} is off the floor of "
                f"{self.settings.world.size_x:g} x {self.settings.world.size_z:g} units"
            )
        if self.referee is not None:
            self.referee.check_start(self.start)

    def _look(self, view: View, pair: StereoPair) -> Step:
        """Add a pair to the map and the model of the world."""
        sight = Sight(view=view, pair=self._stamped(pair))
        if self.belief is not None:
            sight = self._corrected(sight)
        mapped = self._put(sight)
        with self.stopwatch.stage("recognise"):
            self.model.name_obstacles()
        self.views.append(sight.view)
        self.curve.append((len(self.views), self.path_length, self._coverage()))
        parts = {part.name: getattr(mapped, part.name) for part in fields(mapped)}
        known = self.model.floor.known_share
        return Step(**parts, view=sight.view, objects=self.model.objects, known_share=known)

    def _put(self, sight: Sight) -> mapper.Step:
        """Add a pair to the map and the floor."""
        (mapped,) = self.mapper.process(sight.pair, sight.result)
        with self.stopwatch.stage("map"):
            self.model.update(sight.view, mapped.pair, mapped.cloud)
        return mapped

    def _corrected(self, sight: Sight) -> Sight:
        """A pair with its corrected pose; rebuilds the map if other poses changed as well."""
        assert self.belief is not None
        with self.stopwatch.stage("stereo"):
            sight = replace(sight, result=match_points(sight.pair, self.settings))
        with self.stopwatch.stage("localise"):
            T_new_old = self.belief.correct(sight, self.model)
            moved = self.belief.outdated()
            sight = self.belief.keep(sight.moved(T_new_old))
        if self.slip is not None:
            self.slip.correct(T_new_old)
        if moved is not None:
            before = self.model
            self._begin()
            for one in moved:
                self._put(one)
            self.model.remember(before)
            self.views = [one.view for one in moved]
        return sight

    def _stamped(self, pair: StereoPair) -> StereoPair:
        """The pair with a time after the previous one; its number if it has none."""
        stamps_s = self.mapper.trajectory.stamps_s
        if not len(stamps_s) or pair.stamp_s > stamps_s[-1]:
            return pair
        return replace(pair, stamp_s=float(len(stamps_s)))

    def _coverage(self) -> float | None:
        return None if self.referee is None else self.referee.coverage(self.model.floor)

    def _ask(self, controller: Controller, step: Step) -> View | None:
        """Walk to the controller's next view, asked again after a contact; None to stop."""
        view = self._answer(controller, step)
        while view is not None and (contact := self._walk(step.view, view)) is not None:
            if not self.model.floor.touch(contact, self.settings.motion.body_radius):
                self._stop_before(view, contact)
                return None
            view = self._answer(controller, step)
        return view

    def _answer(self, controller: Controller, step: Step) -> View | None:
        """The answer of a controller; None if there is a reason to stop."""
        state = self._state(step)
        try:
            with self.stopwatch.stage("plan"):
                asks = controller.next_view
                view = asks(state) if self.belief is None else self.belief.onward(asks, state)
            if view is None:
                said = controller.result()
                reason = said.partition(";")[0]
                self.stop(reason if reason in STOP_REASONS else "controller ended", said)
                return None
            check_view(view)
        # A plug-in may raise anything; the exploration so far is kept.
        except Exception as error:
            log.debug("the controller failed", exc_info=True)
            self.stop("controller failed", f"{type(error).__name__}: {error}")
            return None
        return view

    def _walk(self, start: View, end: View) -> Array | None:
        """Go to a view; if an object blocks the path, stay and return the contact position (2,)."""
        path = path_between(start, end)
        judge = self.slip or self.referee
        contact = None if judge is None else judge.walk(path)
        if contact is None:
            self.path_length += length_of(path)
        return contact

    def _stop_before(self, view: View, contact: Array) -> None:
        """Stop because the controller walks into a known obstacle."""
        (x, z), (by_x, by_z) = view.position[[0, 2]], contact
        way = f"the path to x {x:.2f}, z {z:.2f} runs into an object at x {by_x:.2f}, z {by_z:.2f}"
        self.stop("controller failed", f"{way}, as the previous path did")

    def _state(self, step: Step) -> State:
        return State(
            num_pairs=len(self.views),
            view=step.view,
            pair=step.pair,
            voxel_map=self.model.voxel_map,
            floor=self.model.floor,
            obstacles=self.model.obstacles,
            detections=self.model.detections,
            refuted=self.model.refuted,
            sure_range=self.model.sure_range,
            objects=self.model.objects,
            simulator=None if self.referee is None else self.referee.world,
            settings=self.settings if self.belief is None else self.belief.cautious,
        )

    def exploration(self) -> Exploration:
        """The results so far, whatever ended the exploration."""
        self.mapper.reached.say()
        voxels = self.mapper.voxels()
        recognition = self.mapper.recognise(voxels)
        floor, trajectory = self.model.floor, self.mapper.trajectory
        return Exploration(
            reconstruction=Reconstruction(
                map=self.mapper.voxel_map,
                voxels=voxels,
                objects=recognition.objects,
                trajectory=trajectory,
            ),
            recognition=recognition,
            clearest=self.mapper.clearest,
            views=tuple(self.views),
            known_free=floor.centres(np.argwhere(floor.known_free)),
            stop_reason=self.stop_reason,
            message=self.message,
            metrics=self._metrics(recognition),
            true_trajectory=None if self.slip is None else self.slip.trajectory(trajectory),
        )

    def _metrics(self, recognition: Recognition) -> dict[str, Any]:
        timeline = [*self.model.timeline, (len(self.views), recognition.objects)]
        true = dict.fromkeys(("path_bound", "oracle_path", "min_clearance"))
        errors = {} if self.slip is None else self.slip.errors(self.mapper.trajectory)
        return {
            "num_pairs": len(self.views),
            "num_points": self.mapper.num_points,
            "num_objects": len(recognition.objects),
            "path_length": self.path_length,
            "coverage": self._coverage(),
            "pairs_until_objects": pairs_until_objects(timeline, recognition.objects),
            "stop_reason": self.stop_reason,
            "curve": [list(point) for point in self.curve],
            **self.mapper.reached.metrics,
            **errors,
        } | (self.referee.metrics(self.start) if self.referee else true)
