"""Left and right image, with matched points: channels, clicks, export of frames."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app import marks
from recon.app.archive import archive
from recon.app.channels import CHANNELS, PLAIN, UNITS, Points
from recon.app.painter import Painter
from recon.app.simulation import Sight, Simulation
from recon.app.source import as_source
from recon.app.widgets import button, card, chooser, line, nicegui, note, pane, testid
from recon.exports.encoding import encode_image
from recon.figures import scales
from recon.records import as_rgb

REACH_PX = 6.0
SIDES = ("left", "right")
PLAIN_COLOUR = np.array([20, 20, 20], np.uint8)
MARK = "#e8650a"
HINT = "show the feature points, then click one"
FRAMES = Path("frames")
"""Folder of exported frames, in the working directory."""


class ImagePanes:
    """The panes of both cameras, and the card for their options."""

    def __init__(self, simulation: Simulation, complain: Callable[[str], Any]) -> None:
        self.simulation = simulation
        self.complain = complain
        self.sight: Sight | None = None
        self.channel = PLAIN
        self.shown = {"left": False, "right": False}
        self.picked: int | None = None
        self.painter: Painter[Sight] = Painter(self._look, self._show, complain)
        eyes = simulation.settings.eyes
        ui = nicegui()
        self.panes = {}
        for side in SIDES:
            self.panes[side] = pane(
                f"pane-{side}", (eyes.width, eyes.height),
                lambda event, side=side: self._click(side, event), ("click",),
            )  # fmt: skip
            with self.panes[side], ui.context_menu():
                ui.menu_item("Export Frame", on_click=self._export)

    def add_card(self) -> None:
        """Add the card for the feature points, and for the clicked one."""
        ui = nicegui()
        with card("Feature points"):
            with ui.row().classes("items-center gap-2"):
                self.toggle = testid(ui.checkbox("feature points").props("dense"),
                                     "toggle-features")  # fmt: skip
                self.toggle.on_value_change(lambda event: self._toggle(SIDES, is_on=event.value))
                self.boxes = {}
                for side in SIDES:
                    box = testid(ui.checkbox(side).props("dense"), f"toggle-features-{side}")
                    box.on_value_change(
                        lambda event, side=side: self._toggle((side,), is_on=event.value)
                    )
                    self.boxes[side] = box
            with line():
                chooser("channel", "colour by channel", CHANNELS, PLAIN, self._choose)
                button("export-frame", "Export Frame", self._export)
            self.info = note("point-info", HINT)
            self.info.classes("recon-told")

    def _toggle(self, sides: tuple[str, ...], *, is_on: bool) -> None:
        for side in sides:
            self.shown[side] = bool(is_on)
            self.boxes[side].set_value(bool(is_on))
        self.painter.ask()

    def _choose(self, channel: str) -> None:
        self.channel = channel
        if channel != PLAIN and not any(self.shown.values()):
            self.toggle.set_value(True)
        self.painter.ask()

    def _look(self) -> Sight:
        return self.simulation.look(with_points=any(self.shown.values()))

    def _show(self, sight: Sight) -> None:
        self.sight = sight
        self.picked = None
        for side in SIDES:
            image = sight.pair.left if side == "left" else sight.pair.right
            if sight.points is not None and self.shown[side]:
                image = self._dotted(image, sight.points, side)
            self.panes[side].set_source(as_source(image))
        self._mark()

    def _dotted(self, image: NDArray[np.uint8], points: Points, side: str) -> NDArray[np.uint8]:
        """The image with a dot at every point, in the colour of the channel."""
        dotted = as_rgb(image).copy()
        at = points.left_px if side == "left" else points.right_px
        u, v = np.rint(at).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < dotted.shape[1]) & (v < dotted.shape[0])
        colours = self._colours(points)
        dotted[v[inside], u[inside]] = colours[inside] if colours.ndim == 2 else colours
        return dotted

    def _colours(self, points: Points) -> NDArray[np.uint8]:
        if self.channel == PLAIN or not len(points):
            return PLAIN_COLOUR
        values = points.channels[self.channel]
        return scales.rgb(scales.coloured(values, scales.disparity()), values)

    def _mark(self) -> None:
        points = None if self.sight is None else self.sight.points
        eyes = self.simulation.settings.eyes
        for side in SIDES:
            content = marks.caption(f"{side} image", (eyes.width, eyes.height))
            if points is not None and self.shown[side] and self.channel != PLAIN:
                unit = UNITS.get(self.channel, "")
                label = f"{self.channel} [{unit}]" if unit else self.channel
                content += marks.scale(points.channels[self.channel], label, scales.disparity())
            if points is not None and self.picked is not None:
                at = points.left_px if side == "left" else points.right_px
                u, v = at[self.picked]
                content += marks.ring(u, v, 5.0, MARK, f'data-testid="mark-{side}"')
            self.panes[side].set_content(content)

    def _click(self, side: str, event: Any) -> None:
        points = None if self.sight is None else self.sight.points
        if points is None:
            self.info.set_text(HINT)
            return
        self.picked = points.nearest(side, (event.image_x, event.image_y), REACH_PX)
        text = "no point there" if self.picked is None else points.describe(self.picked)
        self.info.set_text(text)
        self._mark()

    def _export(self) -> None:
        """Write both images with a JSON of camera and time, below FRAMES and as a download."""
        if self.sight is None:
            self.complain("nothing is drawn yet")
            return
        pair = self.sight.pair
        about = {"scene": self.simulation.scene.name, "camera": self.simulation.values(),
                 "time_s": round(time.time(), 3)}  # fmt: skip
        files = {
            "left.png": encode_image(pair.left), "right.png": encode_image(pair.right),
            "frame.json": (json.dumps(about, indent=2) + "\n").encode(),
        }  # fmt: skip
        try:
            folder = _new_folder(self.simulation.scene.stem)
            for name, content in files.items():
                (folder / name).write_bytes(content)
        except OSError as error:
            self.complain(f"{FRAMES}: {error.strerror or error}")
            return
        nicegui().download.content(archive(files), f"{folder.name}.zip")
        self.complain(f"frame written to {folder}")


def _new_folder(stem: str) -> Path:
    """The next free folder for a frame."""
    number = 1
    while (folder := FRAMES / f"{stem}-{number:03d}").exists():
        number += 1
    folder.mkdir(parents=True)
    return folder
