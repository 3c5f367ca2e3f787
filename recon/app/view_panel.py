"""A 3D view controlled by mouse and keys; a click identifies a row."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.app import drawing, view_marks
from recon.app.drawing import View, draw
from recon.app.filters import MOST_AT_REST, MOST_MOVING, Filter, Selection
from recon.app.layers import Layer
from recon.app.looks import Look
from recon.app.orbit import DEFAULT, VIEWS, Orbit
from recon.app.painter import Painter
from recon.app.source import as_source
from recon.app.widgets import nicegui, pane
from recon.records import Trajectory

CLICK_PX = 4.0
"""Maximum movement of the mouse for a click; more rotates the view."""
REST_S = 0.35
"""Seconds without rotation after which everything is drawn."""
KEY_PX = 25.0
KEYS = {
    "ArrowLeft": (-KEY_PX, 0.0), "ArrowRight": (KEY_PX, 0.0),
    "ArrowUp": (0.0, -KEY_PX), "ArrowDown": (0.0, KEY_PX),
}  # fmt: skip
EVENTS = ("mousedown", "mousemove", "mouseup", "mouseleave", "dblclick")


class ViewPanel:
    """The scene of one exhibit.

    Parameters
    ----------
    name : str
        Its `data-testid`.
    layer : Layer
    clicked : callable
        Called with the clicked row, or None.
    drawn : callable
        Called with every shown `View`.
    complain : callable
        Called with the text of an error.
    """

    def __init__(
        self,
        name: str,
        layer: Layer,
        clicked: Callable[[int | None], Any],
        drawn: Callable[[View], Any],
        complain: Callable[[str], Any],
    ) -> None:
        self.filter = Filter()
        self.selection = Selection(layer, self.filter)
        self.look = Look()
        self.orbit = self._home = Orbit.round(*layer.box)
        self.trajectory: Trajectory | None = None
        self.pair = 0
        self.names: view_marks.Names = ()
        self.picked: int | None = None
        self.view: View | None = None
        self.followers: list[ViewPanel] = []
        self._clicked, self._drawn = clicked, drawn
        self._is_moving = False
        self._pressed: tuple[float, float, float] | None = None
        self._last = (0.0, 0.0)
        self.painter = Painter(self._draw, self._show, complain)
        self.image = pane(name, drawing.SIZE, self._on_mouse, EVENTS)
        self.image.on("wheel.prevent", self._on_wheel, ["deltaY"], throttle=0.05)
        self.image.on("keydown", self._on_key, ["key"])
        self._rest = nicegui().timer(REST_S, self._stand_still, active=False, once=False)

    def begin(self, orbit: Orbit) -> None:
        """Show from a viewpoint, which becomes the default."""
        self.orbit = self._home = orbit
        self.painter.ask()

    def change_layer(self, layer: Layer) -> None:
        """Show another layer from the same viewpoint."""
        self.picked = None
        self._select(layer, self.filter)

    def refilter(self, chosen: Filter) -> None:
        """Show the rows of another filter."""
        self._select(self.layer, chosen)

    @property
    def layer(self) -> Layer:
        """The layer of the next drawing."""
        return self.selection.layer

    @property
    def kept(self) -> NDArray[np.bool_]:
        """(N,) mask of the rows that pass the filter."""
        return self.selection.kept

    def _select(self, layer: Layer, chosen: Filter) -> None:
        self.filter = chosen
        self.selection = Selection(layer, chosen)
        self.painter.ask()

    def look_from(self, view: str) -> None:
        """Turn to one of VIEWS."""
        orbit = self.orbit.facing(self._home) if view == DEFAULT else self.orbit.seen_from(view)
        self._turn(orbit, is_moving=False)

    def _draw(self) -> View:
        most = MOST_MOVING if self._is_moving else MOST_AT_REST
        look = replace(self.look, is_quick=self._is_moving)
        selection = self.selection
        return draw(selection.layer, selection.shown(most), self.orbit, look)

    def _show(self, view: View) -> None:
        self.view = view
        self.image.set_source(as_source(view.image, ".jpg"))
        self.image.set_content(
            view_marks.of_view(view, self.look, self.names)
            + view_marks.of_trajectory(view.lens, self.trajectory, self.pair)
            + view_marks.of_row(view.lens, self.layer, self.picked)
        )
        self._drawn(view)

    def _turn(self, orbit: Orbit, *, is_moving: bool = True) -> None:
        for panel in (self, *self.followers):
            panel.orbit = orbit
            panel._is_moving = is_moving
            panel.painter.ask()
        if is_moving:
            self._rest.deactivate()
            self._rest.activate()

    def _stand_still(self) -> None:
        if self._pressed is None:
            self._rest.deactivate()
            self._turn(self.orbit, is_moving=False)

    def _on_mouse(self, event: Any) -> None:
        at = event.image_x, event.image_y
        if event.type == "mousedown":
            self._pressed = (*at, 0.0)
        elif event.type == "dblclick":
            self._turn(Orbit.round(*self.layer.box).facing(self._home), is_moving=False)
        elif self._pressed is not None and event.type == "mousemove" and event.buttons:
            self._drag(at, moves=event.shift or event.buttons != 1)
        elif self._pressed is not None:
            self._release(at, is_click=event.type == "mouseup")
        self._last = at

    def _drag(self, at: tuple[float, float], *, moves: bool) -> None:
        right, down = at[0] - self._last[0], at[1] - self._last[1]
        assert self._pressed is not None
        x, y, way = self._pressed
        self._pressed = (x, y, way + abs(right) + abs(down))
        if self._pressed[2] > CLICK_PX:
            height = drawing.SIZE[1]
            orbit = self.orbit
            self._turn(orbit.moved(right, down, height) if moves else orbit.turned(right, down))

    def _release(self, at: tuple[float, float], *, is_click: bool) -> None:
        assert self._pressed is not None
        way, self._pressed = self._pressed[2], None
        if way <= CLICK_PX and is_click:
            self._pick(at)
        else:
            self._turn(self.orbit, is_moving=False)

    def _pick(self, at: tuple[float, float]) -> None:
        self.picked = None
        if self.view is not None and self.view.layer is self.layer:
            self.picked = self.view.row_at(*at)
        self._clicked(self.picked)
        self.painter.ask()

    def _on_wheel(self, event: Any) -> None:
        self._turn(self.orbit.zoomed(-np.sign(event.args["deltaY"])))

    def _on_key(self, event: Any) -> None:
        key = event.args["key"]
        if key in KEYS:
            self._turn(self.orbit.turned(*KEYS[key]))
        elif key in ("+", "=", "-"):
            self._turn(self.orbit.zoomed(-1.0 if key == "-" else 1.0))
        elif key.isdecimal() and 0 < int(key) <= len(VIEWS):
            self.look_from(list(VIEWS)[int(key) - 1])
