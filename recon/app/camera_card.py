"""Camera settings: number fields that follow dragging and control the cameras."""

from collections.abc import Callable
from functools import partial
from typing import Any

from recon.app.simulation import Simulation
from recon.app.widgets import card, chooser, nicegui, number_field
from recon.errors import InputError

FIELDS = {
    "x": "camera x", "y": "camera y", "z": "camera z",
    "target_x": "target x", "target_y": "target y", "target_z": "target z",
    "focal_length": "focal length", "fov_deg": "field of view [deg]", "baseline": "baseline",
    "near": "near", "far": "far", "width": "width [px]", "height": "height [px]",
}  # fmt: skip
NAMES = {"fov_deg": "fov"}
GAZES = ("shift", "toe-in")
"""Both cameras look at the target by shifted sensors or by turning inwards."""


class CameraCard:
    """The fields of the cameras."""

    def __init__(
        self, simulation: Simulation, moved: Callable[[], Any], complain: Callable[[str], Any]
    ) -> None:
        self.simulation = simulation
        self._moved, self._complain = moved, complain
        self.fields: dict[str, Any] = {}
        with card("Camera Settings"), nicegui().element("div").classes("recon-fields"):
            for name, value in simulation.values().items():
                testid = "field-" + NAMES.get(name, name).replace("_", "-")
                change = partial(self._change, name)
                self.fields[name] = number_field(testid, FIELDS[name], value, change)
            self.gaze = chooser(
                "field-gaze", "gaze", GAZES, simulation.settings.eyes.gaze, self._turn
            )

    def show(self) -> None:
        """Show the current values of the cameras."""
        for name, value in self.simulation.values().items():
            self.fields[name].set_value(round(value, 6))
        self.gaze.set_value(self.simulation.settings.eyes.gaze)

    def _turn(self, gaze: str) -> None:
        if gaze != self.simulation.settings.eyes.gaze:
            self.simulation.change_settings({"eyes": {"gaze": gaze}})
            self._moved()

    def _change(self, name: str, _: Any = None) -> None:
        wanted = self.fields[name].value
        if wanted == round(self.simulation.values()[name], 6):
            return
        try:
            self.simulation.change(name, wanted)
        except InputError as error:
            self.show()
            self._complain(str(error))
        else:
            self._moved()
