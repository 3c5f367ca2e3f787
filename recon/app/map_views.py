"""The top and front views, with draggable camera and target, and the growing map."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.app import marks
from recon.app.map_panes import MapPane, front_pane, top_pane
from recon.app.objects_table import WHILE_EXPLORED, ObjectsTable
from recon.app.painter import Painter
from recon.app.simulation import MAP_PX
from recon.app.source import as_source
from recon.app.widgets import card, nicegui, pane
from recon.errors import InputError

if TYPE_CHECKING:
    from recon.app.visit import Visit

EVENTS = ("mousedown", "mousemove", "mouseup")
FRONT_HEIGHT = 192
"""Height of the front view in pixels; above the world there is sky."""

Drawn = list[tuple[MapPane, NDArray[np.uint8]]]


class MapViews:
    """Both map panes of one visitor."""

    def __init__(
        self, visit: "Visit", moved: Callable[[], Any], complain: Callable[[str], Any]
    ) -> None:
        self.visit = visit
        self.simulation = visit.simulation
        self._moved, self._complain = moved, complain
        self.painter: Painter[Drawn] = Painter(self._draw, self._show, complain)
        self._bases: tuple[Any, Drawn] | None = None
        self._grabbed: str | None = None
        self._selected: int | None = None
        self.panes: dict[str, MapPane] = {}
        self.images = {"top": self._pane("top", MAP_PX)}
        ui = nicegui()
        with ui.element("div").classes("recon-cell"):
            self.images["front"] = self._pane("front", FRONT_HEIGHT)
            with ui.element("div").classes("recon-rest"), card("Objects"):
                self.table = ObjectsTable(
                    "objects", self.simulation.objects, self._select, WHILE_EXPLORED
                )

    def _pane(self, name: str, height: int) -> Any:
        return pane(f"pane-{name}", (MAP_PX, height), partial(self._on_mouse, name), EVENTS)

    def _select(self, number: int | None) -> None:
        self._selected = number
        self.mark()

    def mark(self) -> None:
        """Place the symbols of camera and target."""
        simulation = self.simulation
        walk = self.visit.walk
        for name, shown in self.panes.items():
            way = shown.way(walk.positions) if walk is not None else ""
            symbols = shown.symbols(
                simulation.position, simulation.target, simulation.settings.eyes.fov_deg
            )
            frame = marks.caption(f"{name} view", shown.size)
            frame += marks.length_bar(1.0 / shown.unit, shown.size)
            names = shown.names(simulation.objects, self._selected)
            self.images[name].set_content(way + frame + symbols + names)

    def _base(self) -> Drawn:
        """The panes without a map, drawn once per world."""
        if self._bases is None or self._bases[0] is not self.simulation.world:
            top, front = self.simulation.maps()
            floor = self.simulation.settings.world
            panes = [(top_pane(floor, top), top), front_pane(floor, front, FRONT_HEIGHT)]
            self._bases = self.simulation.world, panes
        return self._bases[1]

    def _draw(self) -> Drawn:
        walk = self.visit.walk
        cells = {} if walk is None else dict(walk.cells)
        size = self.simulation.settings.map.cell_size
        return [(one, one.with_cells(image, cells, size)) for one, image in self._base()]

    def _show(self, drawn: Drawn) -> None:
        self.panes = {one.name: one for one, _ in drawn}
        for one, image in drawn:
            self.images[one.name].set_source(as_source(image))
        self.mark()

    def _on_mouse(self, name: str, event: Any) -> None:
        if name not in self.panes:
            return
        shown, at = self.panes[name], (event.image_x, event.image_y)
        simulation = self.simulation
        if event.type == "mousedown":
            self._grabbed = shown.grabbed(at, simulation.position, simulation.target)
        elif event.type == "mouseup" or not event.buttons:
            self._grabbed = None
        elif self._grabbed is not None:
            self._drag(shown, at)

    def _drag(self, shown: MapPane, at: tuple[float, float]) -> None:
        position, target = self.simulation.position, self.simulation.target
        try:
            if self._grabbed == "camera":
                self.simulation.move(shown.moved(position, at), target)
            else:
                self.simulation.move(position, shown.moved(target, at))
        except InputError as error:
            self._complain(str(error))
        else:
            self._moved()
