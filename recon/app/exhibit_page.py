"""One exhibit on the inspector's page: its view, options, readings and exports."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from recon.app.drawing import View
from recon.app.exhibit import Exhibit
from recon.app.filter_card import FilterCard
from recon.app.layers import Layer
from recon.app.looks import COLOUR, LENGTHS
from recon.app.objects_table import ObjectsTable
from recon.app.orbit import VIEWS, Orbit
from recon.app.pair_viewer import PairViewer
from recon.app.taking import ENDINGS, packed
from recon.app.threads import in_thread
from recon.app.view_panel import ViewPanel
from recon.app.widgets import button, card, chooser, line, nicegui, note, side, testid
from recon.errors import InputError, ReconError
from recon.records import PointCloud


class ExhibitPage:
    """The view of an exhibit and the cards beside it.

    Parameters
    ----------
    exhibit : Exhibit
    suffix : str
        Suffix of every `data-testid`, if there are two exhibits.
    is_alone : bool
        True if the cards are beside the view, not below it.
    """

    def __init__(self, exhibit: Exhibit, suffix: str, *, is_alone: bool) -> None:
        self.exhibit = exhibit
        self.suffix = suffix
        self.layers = dict(exhibit.layers) or {"nothing": _nothing()}
        self.layer = next(iter(self.layers.values()))
        self._before: np.ndarray[Any, Any] | None = None
        ui = nicegui()
        with ui.element("div").classes("recon-main"):
            self._add_view()
            if not is_alone:
                self._add_cards()
        if is_alone:
            with side():
                self._add_cards()
        self.say("\n".join(exhibit.notices))
        self.panel.begin(self._first_orbit())

    def named(self, name: str) -> str:
        """A `data-testid` of this exhibit."""
        return name + self.suffix

    def set_dark(self, *, is_dark: bool) -> None:
        """Draw on a dark or a light background."""
        self._look(is_dark=is_dark)

    def say(self, text: str) -> None:
        """Show an error message; the view stays."""
        self.message.set_text(text)

    def _first_orbit(self) -> Orbit:
        """The view of the first camera of a recording; else from outside, obliquely."""
        orbit = Orbit.round(*self.layer.box)
        trajectory = self.exhibit.trajectory
        if not self.exhibit.is_recorded or trajectory is None or not len(trajectory):
            return orbit
        return orbit.behind(trajectory.T_world_left[0])

    def _add_view(self) -> None:
        ui = nicegui()
        self.panel = ViewPanel(
            self.named("scene"), self.layer, self._clicked, self._drawn, lambda text: self.say(text)
        )
        self.panel.look = replace(self.panel.look, unit=self.exhibit.unit)
        self.panel.trajectory = self.exhibit.trajectory
        self.panel.names = tuple(self.exhibit.objects)
        with ui.element("div").classes("recon-buttons").style("padding: 2px 0"):
            for view in VIEWS:
                ui.button(view, on_click=partial(self.panel.look_from, view)).props(
                    "flat dense no-caps"
                )
            self.share = note(self.named("shown-share"), "drawing ...")
        self.message = note(self.named("message"), "", "recon-message")
        with card("Clicked"):
            self.info = note(self.named("point-info"), "click a cell or a point")
            self.info.classes("recon-told")

    def _add_cards(self) -> None:
        with card("Layer and colour"):
            self._add_choices()
        with card("Filters"):
            self.filters = FilterCard(
                self.named, self.layer, self.exhibit.unit, self.panel.refilter
            )
        with card("Objects"):
            self.table = ObjectsTable(self.named("objects"), self.exhibit.objects, self._select)
        with card("Pairs"):
            self.pairs = PairViewer(self.exhibit, self.suffix, self._show_pair, self.say)
        with card("Export what is shown"):
            self._add_export()
        if self.exhibit.figures:
            self._add_figures()

    def _add_choices(self) -> None:
        ui = nicegui()
        first = next(iter(self.layers))
        chooser(self.named("layer"), "layer", list(self.layers), first, self._change_layer)
        self.columns = ui.column().classes("w-full gap-0")
        self._offer_columns()
        has_solids = any(found.parts for found in self.exhibit.objects)
        solids = ui.checkbox("fitted solids over the cells", value=False).props("dense")
        testid(solids, self.named("solids")).set_enabled(has_solids)
        shown = tuple(self.exhibit.objects)
        solids.on_value_change(lambda event: self._look(solids=shown if event.value else ()))

    def _offer_columns(self) -> None:
        self.columns.clear()
        with self.columns:
            names = [COLOUR, *self.layer.columns]
            chooser(self.named("colour-by"), "colour by", names, COLOUR,
                    lambda name: self._look(colour_by=name))  # fmt: skip

    def _add_export(self) -> None:
        with line():
            self.ending = chooser(
                self.named("format"), "format", ENDINGS, ENDINGS[0], lambda _: None
            )
            button(self.named("export"), "export", self._export)

    def _add_figures(self) -> None:
        ui = nicegui()
        with card("Figures of the run"):
            names = {path.stem: path for path in self.exhibit.figures}
            first = "overview" if "overview" in names else next(iter(names))
            with ui.dialog() as whole, ui.card().style("max-width: 95vw; width: 95vw"):
                large = ui.image().props("fit=contain").style("max-height: 85vh")

            def show(name: str) -> None:
                try:
                    for image in (small, large):
                        image.set_source(names[name])
                except OSError as error:
                    self.say(f"{names[name]}: {error.strerror or error}")

            chooser(self.named("figure"), "figure (a click enlarges it)", list(names), first, show)
            small = ui.image().classes("w-full cursor-pointer").on("click", whole.open)
            show(first)

    def _change_layer(self, name: str) -> None:
        self.layer = self.layers[name]
        self._offer_columns()
        self.panel.look = replace(self.panel.look, colour_by=COLOUR)
        self.panel.change_layer(self.layer)
        self.filters.begin(self.layer)

    def _look(self, **changes: Any) -> None:
        self.panel.look = replace(self.panel.look, **changes)
        self.panel.painter.ask()

    def _select(self, number: int | None) -> None:
        self._look(selected=number)

    def _clicked(self, row: int | None) -> None:
        if row is None:
            self.info.set_text("nothing there")
            return
        layer = self.panel.layer
        lines = [f"{layer.noun.removesuffix('s')} {row}"]
        unit = self.exhibit.unit
        lines += [
            f"{name}: {value:.6g}{f' {unit}' if name in LENGTHS else ''}".rstrip()
            for name, value in layer.values(row).items()
        ]
        place = layer.places[row]
        if self._before is not None:
            away = float(np.linalg.norm(place - self._before))
            lines.append(f"from the last click: {away:.6g} {self.exhibit.unit}")
        self._before = place
        self.info.set_text("\n".join(lines))
        if "object" in layer.columns and layer.columns["object"][row] >= 0:
            self.table.select(int(layer.columns["object"][row]))

    def _drawn(self, view: View) -> None:
        self.share.set_text(view.shown.share(view.layer.noun))
        # Late: the scene comes first.
        self.pairs.begin()

    def _show_pair(self, number: int) -> None:
        self.panel.pair = number
        self.panel.painter.ask()

    async def _export(self) -> None:
        ui = nicegui()
        try:
            data = self.panel.layer.select(self.panel.kept)
            if not self.panel.kept.any():
                raise InputError("nothing is shown, so there is nothing to export")
            stem, ending = self.exhibit.path.stem, self.ending.value
            name, content = await in_thread(lambda: packed(data, stem, ending))
        except (ReconError, OSError) as error:
            self.say(str(error))
            return
        ui.download.content(content, name)
        self.say(f"{name}: {int(self.panel.kept.sum()):,} {self.panel.layer.noun} exported")


def _nothing() -> Layer:
    from recon.app.layers import layer_of

    return layer_of(PointCloud(points=np.empty((0, 3)), colours=np.empty((0, 3), np.uint8)))
