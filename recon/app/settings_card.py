"""All settings as editable TOML text with download; the look of the world as switches."""

import tomllib
from collections.abc import Callable
from typing import Any

from recon.app.simulation import Simulation
from recon.app.widgets import button, card, chooser, nicegui, number_field, testid
from recon.errors import InputError, ReconError
from recon.settings import to_toml
from recon.world.renderers import RENDERERS

SWITCHES = {"shading": "sun and shade", "sky": "sky", "mipmaps": "mipmaps"}


class SettingsCard:
    """The settings of one visitor's world and run."""

    def __init__(
        self, simulation: Simulation, changed: Callable[[], Any], complain: Callable[[str], Any]
    ) -> None:
        self.simulation = simulation
        self._changed, self._complain = changed, complain
        ui = nicegui()
        render = simulation.settings.render
        with card("Light, noise and renderer"):
            with ui.row().classes("items-center gap-3"):
                for name, label in SWITCHES.items():
                    box = ui.checkbox(label, value=getattr(render, name)).props("dense")
                    testid(box, f"render-{name}").on_value_change(
                        lambda event, name=name: self._change({"render": {name: event.value}})
                    )
            self.noise = number_field(
                "render-noise", "noise [grey levels]", render.noise,
                lambda _: self._change({"render": {"noise": self.noise.value}}),
            )  # fmt: skip
            names = ["raycast", *[name for name in RENDERERS.names() if name != "raycast"]]
            chooser("renderer", "renderer", names, render.renderer,
                    lambda name: self._change({"render": {"renderer": name}}))  # fmt: skip
        with card("Settings"):
            with ui.element("div").classes("recon-buttons"):
                button("settings-apply", "apply", self._apply)
                button("settings-save", "save as TOML", self._save)
            self.text = ui.textarea(value=to_toml(simulation.settings))
            testid(self.text.classes("w-full recon-settings").props("dense outlined"), "settings")

    def _apply(self) -> None:
        try:
            tree = tomllib.loads(self.text.value or "")
        except tomllib.TOMLDecodeError as error:
            self._complain(f"settings: {error}")
        else:
            self._change(tree)

    def _change(self, tree: dict[str, Any]) -> None:
        try:
            if not all(isinstance(table, dict) for table in tree.values()):
                raise InputError("settings: every value needs a table, such as [map] cell_size = 1")
            self.simulation.change_settings(tree)
        except (ReconError, OSError) as error:
            self._complain(str(error))
        else:
            self._changed()
            self.text.set_value(to_toml(self.simulation.settings))

    def _save(self) -> None:
        content = to_toml(self.simulation.settings).encode()
        nicegui().download.content(content, "settings.toml")
