"""One exhibit on the inspector's page: its view, and all that is chosen, read and taken from it."""

from dataclasses import replace
from typing import Any

import numpy as np

from recon.app.drawing import View
from recon.app.exhibit import Exhibit
from recon.app.filters import AT_LEAST, AT_MOST, Filter
from recon.app.layers import COLOUR, Layer
from recon.app.objects_table import ObjectsTable
from recon.app.orbit import VIEWS
from recon.app.pair_viewer import PairViewer
from recon.app.taking import ENDINGS, packed
from recon.app.threads import in_thread
from recon.app.view_panel import ViewPanel
from recon.app.widgets import card, chooser, nicegui, note, slider, testid
from recon.errors import InputError, ReconError
from recon.records import PointCloud

NUM_STEPS = 200
"""Of a slider over numbers that are not counts."""


class ExhibitPage:
    """The view of an exhibit and the cards beside it.

    Parameters
    ----------
    exhibit : Exhibit
    suffix : str
        After every `data-testid`, where there are two.
    is_alone : bool
        Whether there is room for cards beside the view, not below it.
    """

    def __init__(self, exhibit: Exhibit, suffix: str, *, is_alone: bool) -> None:
        self.exhibit = exhibit
        self.suffix = suffix
        self.layers = dict(exhibit.layers) or {"nothing": _nothing()}
        self.layer = next(iter(self.layers.values()))
        self.filter = Filter()
        self._before: np.ndarray[Any, Any] | None = None
        ui = nicegui()
        with ui.element("div").classes("recon-main"):
            self._add_view()
            if not is_alone:
                self._add_cards()
        if is_alone:
            with ui.element("div").classes("recon-side"):
                self._add_cards()
        self.panel.painter.ask()

    def named(self, name: str) -> str:
        """A `data-testid` of this exhibit."""
        return name + self.suffix

    def set_dark(self, *, is_dark: bool) -> None:
        """Draw on a dark or a light ground."""
        self._look(is_dark=is_dark)

    def say(self, text: str) -> None:
        """Say what went wrong; what is shown stays."""
        self.message.set_text(text)

    def _add_view(self) -> None:
        ui = nicegui()
        self.panel = ViewPanel(
            self.named("scene"), self.layer, self._clicked, self._drawn, lambda text: self.say(text)
        )
        self.panel.trajectory = self.exhibit.trajectory
        self.panel.names = tuple(self.exhibit.objects)
        with ui.row().classes("w-full items-center gap-2"):
            for view in VIEWS:
                ui.button(view, on_click=lambda view=view: self.panel.look_from(view)).props(
                    "flat dense no-caps size=sm"
                )
            self.share = note(self.named("shown-share"), "reading ...")
        self.message = note(self.named("message"), "", "recon-message")

    def _add_cards(self) -> None:
        with card("What is shown, and in which colour"):
            self._add_choices()
        with card("Thresholds and clip box"):
            self._add_filters()
        with card("What was clicked"):
            self.info = note(self.named("point-info"), "click a cell or a point")
        with card("Objects"):
            self.table = ObjectsTable(self.named("objects"), self.exhibit, self._select)
        with card("Pairs"):
            self.pairs = PairViewer(self.exhibit, self.suffix, self._show_pair, self.say)
        with card("Take what is shown"):
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

    def _add_filters(self) -> None:
        ui = nicegui()
        counts = self.layer.counts
        top = float(np.quantile(counts, 0.995)) if len(counts) else 1.0
        self.least = note(text="at least 1 point")
        slider(self.named("threshold-count"), (1, max(2.0, top), 1), 1, self._at_least("count"))
        for name in (*AT_LEAST[1:], *AT_MOST):
            if name in self.layer.columns:
                self._add_threshold(name)
        low, high = self.layer.box
        with ui.element("div").classes("recon-fields"):
            self.clips = [
                self._add_clip(axis, float(low[axis]), float(high[axis])) for axis in range(3)
            ]

    def _add_threshold(self, name: str) -> None:
        values = self.layer.columns[name]
        known = values[np.isfinite(values)]
        if not len(known) or known.min() == known.max():
            return
        low, high = float(known.min()), float(known.max())
        is_most = name in AT_MOST
        label = note(text=f"{name} at {'most' if is_most else 'least'} "
                     f"{high if is_most else low:.4g}")  # fmt: skip

        def change(value: float) -> None:
            label.set_text(f"{name} at {'most' if is_most else 'least'} {value:.4g}")
            old = self.filter
            if is_most:
                self._refilter(replace(old, most={**old.most, name: value}))
            else:
                self._refilter(replace(old, least={**old.least, name: value}))

        step = (high - low) / NUM_STEPS
        slider(self.named(f"threshold-{name}"), (low, high, step), high if is_most else low, change)

    def _at_least(self, name: str) -> Any:
        def change(value: float) -> None:
            self.least.set_text(f"at least {value:.0f} {'point' if value == 1 else 'points'}")
            self._refilter(replace(self.filter, least={**self.filter.least, name: value}))

        return change

    def _add_clip(self, axis: int, low: float, high: float) -> Any:
        ui = nicegui()
        with ui.column().classes("gap-0"):
            ui.label("xyz"[axis]).classes("recon-note")
            step = max((high - low) / NUM_STEPS, 1e-9)
            clip = ui.range(min=low, max=high, step=step, value={"min": low, "max": high})
            testid(clip, self.named(f"clip-{'xyz'[axis]}")).on_value_change(self._clip)
        return clip

    def _clip(self) -> None:
        ends = [(clip.value["min"], clip.value["max"]) for clip in self.clips]
        low, high = np.array(ends, np.float64).T
        margin = 1e-6 * np.maximum(high - low, 1e-9)
        self._refilter(replace(self.filter, low=low - margin, high=high + margin))

    def _add_export(self) -> None:
        ui = nicegui()
        with ui.row().classes("w-full items-end no-wrap gap-2"):
            self.ending = chooser(
                self.named("format"), "format", ENDINGS, ENDINGS[0], lambda _: None
            )
            button = ui.button("export", on_click=self._export).props("dense no-caps outline")
            testid(button, self.named("export"))

    def _add_figures(self) -> None:
        ui = nicegui()
        with card("Figures of the run"):
            names = {path.stem: path for path in self.exhibit.figures}
            image = ui.image().classes("w-full")

            def show(name: str) -> None:
                try:
                    image.set_source(names[name])
                except OSError as error:
                    self.say(f"{names[name]}: {error.strerror or error}")

            first = "overview" if "overview" in names else next(iter(names))
            chooser(self.named("figure"), "figure", list(names), first, show)
            show(first)

    def _change_layer(self, name: str) -> None:
        self.layer = self.layers[name]
        self._offer_columns()
        self.panel.look = replace(self.panel.look, colour_by=COLOUR)
        self.panel.change_layer(self.layer)

    def _look(self, **changes: Any) -> None:
        self.panel.look = replace(self.panel.look, **changes)
        self.panel.painter.ask()

    def _refilter(self, chosen: Filter) -> None:
        self.filter = chosen
        self.panel.refilter(chosen)

    def _select(self, number: int | None) -> None:
        self._look(selected=number)

    def _clicked(self, row: int | None) -> None:
        if row is None:
            self.info.set_text("nothing there")
            return
        layer = self.panel.layer
        lines = [f"{layer.noun.removesuffix('s')} {row}"]
        lines += [f"{name}: {value:.6g}" for name, value in layer.values(row).items()]
        place = layer.places[row]
        if self._before is not None:
            away = float(np.linalg.norm(place - self._before))
            lines.append(f"from the last click: {away:.6g} {self.exhibit.unit}")
        self._before = place
        self.info.set_text("\n".join(lines))
        if "object" in layer.columns and layer.columns["object"][row] >= 0:
            self.table.select(int(layer.columns["object"][row]))

    def _drawn(self, view: View) -> None:
        self.share.set_text(view.shown.share(self.panel.layer.noun))

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
