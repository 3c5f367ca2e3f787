"""The controller and its exploration: step, run, pause, stop; its messages and results."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from recon.app.painter import Painter
from recon.app.walk import Walk
from recon.app.widgets import button, card, chooser, line, nicegui, note, testid
from recon.errors import InputError, ReconError
from recon.exploration.controllers import CONTROLLERS, make_controller
from recon.settings import updated

if TYPE_CHECKING:
    from recon.app.visit import Visit

RUNS = Path("runs")
LONG_S = 5.0
"""Stages that take longer show their duration."""
BUTTONS = ("step", "run", "pause", "stop")


class RunCard:
    """The exploration of one visitor."""

    def __init__(self, visit: "Visit", complain: Callable[[str], Any]) -> None:
        self.visit = visit
        self._complain = complain
        ui = nicegui()
        first = visit.simulation.settings.exploration.controller
        with card("Exploration"):
            chooser("controller", "controller", CONTROLLERS.names(), first, self._choose)
            with ui.element("div").classes("recon-buttons"):
                for name in BUTTONS:
                    button(name, name, partial(self._press, name))
            self.info = note("controller-info", "")
            self.result = note("controller-result", "no run yet")
            with line():
                self.name = testid(
                    ui.input("name of the saved run", value=visit.simulation.scene.stem), "run-name"
                )
                self.name.props("dense")
                button("save-run", "save run", self._save)
        self._chosen = first
        self._words: Painter[str] = Painter(self._introduced, self.info.set_text, self._unknown)
        if visit.walk is not None:
            self.show()

    def introduce(self) -> None:
        """Show the strategy of the chosen controller, if not done yet."""
        if not self.info.text:
            self._words.ask()

    def show(self) -> None:
        """Show the progress of the exploration."""
        walk = self.visit.walk
        if walk is None:
            return
        count = len(walk.objects)
        text = f"{walk.state}: {walk.number} pairs, {count} object{'' if count == 1 else 's'}"
        if walk.stage and walk.state in ("running", "stopping"):
            text += f" ({_stage(walk)})"
        self.result.set_text("\n".join(line for line in (text, *_said(walk)) if line))

    def _choose(self, name: str) -> None:
        simulation = self.visit.simulation
        try:
            simulation.change_settings({"exploration": {"controller": name}})
            self._chosen = name
            self._words.ask()
        except ReconError as error:
            self._complain(str(error))

    def _introduced(self) -> str:
        return str(make_controller(self._chosen).info())

    def _unknown(self, fault: str) -> None:
        self.info.set_text(f"{self._chosen}: {fault}")

    def _press(self, name: str) -> None:
        walk = self.visit.walk
        fault = _fault(walk, name)
        self._complain(fault or "")
        if fault is None:
            getattr(walk if walk is not None and not walk.is_over else self._begin(), name)()
            self.show()

    def _begin(self) -> Walk:
        if self.visit.walk is not None:
            self.visit.walk.discard()
        simulation = self.visit.simulation
        settings = updated(simulation.settings, {})
        self.visit.walk = Walk(simulation.scene, settings)
        return self.visit.walk

    def _save(self) -> None:
        walk = self.visit.walk
        name = str(self.name.value or "").strip()
        try:
            if not name or Path(name).name != name or name.startswith("."):
                raise InputError(f"name is {name!r}, but a name without slashes is needed")
            if walk is None:
                raise InputError("no run yet")
            walk.save(RUNS / name)
        except (ReconError, OSError) as error:
            self._complain(str(error))
        else:
            self._complain(f"run written to {RUNS / name}")


def _said(walk: Walk) -> list[str]:
    """Lines with the controller's message, the reason for the end, and warnings."""
    if walk.report is None:
        return [walk.error or walk.said]
    warnings = [notice.text for notice in walk.report.warnings]
    return [f"ended: {walk.report['stop_reason']}. {walk.said}", *warnings]


def _stage(walk: Walk) -> str:
    """The stage, and its duration so far if it is long."""
    if walk.waited_s < LONG_S:
        return walk.stage
    return f"{walk.stage}, for {walk.waited_s:.0f} s"


def _fault(walk: Walk | None, name: str) -> str | None:
    """The reason why a button has no effect now; None if it has one."""
    is_going_on = walk is not None and not walk.is_over
    if name in ("pause", "stop") and not is_going_on:
        return "no run is in progress"
    if walk is not None and walk.state == "stopping":
        return "the run is stopping; wait until it has ended"
    if name == "run" and walk is not None and walk.state == "running":
        return "it is already running"
    return None
