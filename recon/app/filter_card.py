"""Filters of a view: thresholds, a slice, a clip box."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from recon.app.filters import AT_LEAST, AT_MOST, Filter
from recon.app.layers import Layer
from recon.app.looks import with_unit
from recon.app.widgets import chooser, nicegui, note, slider, testid

WHOLE = "none"
NUM_STEPS = 200
"""Number of steps of a slider over values that are not counts."""


class FilterCard:
    """The sliders of one exhibit, rebuilt for every layer.

    Parameters
    ----------
    named : callable
        Returns the `data-testid` for a name.
    layer : Layer
    unit : str
        Unit of lengths.
    refilter : callable
        Called with the chosen `Filter`.
    """

    def __init__(
        self,
        named: Callable[[str], str],
        layer: Layer,
        unit: str,
        refilter: Callable[[Filter], Any],
    ) -> None:
        self.named = named
        self.unit = unit
        self._refilter = refilter
        self._room = nicegui().column().classes("w-full gap-0")
        self.begin(layer, is_first=True)

    def begin(self, layer: Layer, *, is_first: bool = False) -> None:
        """Offer the filters of a layer, initially without effect."""
        self.layer = layer
        self.filter = Filter()
        self._axis, self._share = WHOLE, 0.5
        self._room.clear()
        with self._room:
            self._add_count()
            for name in (*AT_LEAST[1:], *AT_MOST):
                if name in layer.columns:
                    self._add_threshold(name)
            self._add_slices()
            self._add_clips()
        if not is_first:
            self._refilter(self.filter)

    def _change(self, **changes: Any) -> None:
        self.filter = replace(self.filter, **changes)
        self._refilter(self.filter)

    def _add_count(self) -> None:
        counts = self.layer.counts
        top = float(np.quantile(counts, 0.995)) if len(counts) else 1.0
        label = note(words="at least 1 point")

        def change(value: float) -> None:
            label.set_text(f"at least {value:.0f} {'point' if value == 1 else 'points'}")
            self._change(least={**self.filter.least, "count": value})

        slider(self.named("threshold-count"), (1, max(2.0, top), 1), 1, change)

    def _add_threshold(self, name: str) -> None:
        values = self.layer.columns[name]
        known = values[np.isfinite(values)]
        if not len(known) or known.min() == known.max():
            return
        low, high = float(known.min()), float(known.max())
        side = "most" if name in AT_MOST else "least"
        first = high if side == "most" else low
        called = with_unit(name, self.unit)
        label = note(words=f"{called} at {side} {first:.4g}")

        def change(value: float) -> None:
            label.set_text(f"{called} at {side} {value:.4g}")
            self._change(**{side: {**getattr(self.filter, side), name: value}})

        step = (high - low) / NUM_STEPS
        slider(self.named(f"threshold-{name}"), (low, high, step), first, change)

    def _add_slices(self) -> None:
        """Add a slice across one axis, one cell thick."""
        chooser(self.named("slice"), "slice across", (WHOLE, *"xyz"), WHOLE, self._slice_across)
        self._slice_note = note()
        ends = 0.0, 1.0, 1.0 / NUM_STEPS
        self._slice_slider = slider(self.named("slice-at"), ends, 0.5, self._slice_at)
        self._slice_slider.set_visibility(False)

    def _slice_across(self, axis: str) -> None:
        self._axis = axis
        self._slice()

    def _slice_at(self, share: float) -> None:
        self._share = share
        self._slice()

    def _slice(self) -> None:
        self._slice_slider.set_visibility(self._axis != WHOLE)
        if self._axis == WHOLE:
            self._slice_note.set_text("")
            return self._change(slab=None)
        axis = "xyz".index(self._axis)
        low, high = (float(corner[axis]) for corner in self.layer.box)
        middle, half = low + self._share * (high - low), 0.5 * self.layer.thickness
        first, last = middle - half, middle + half
        name = with_unit(self._axis, self.unit)
        self._slice_note.set_text(f"{name} from {first:.4g} to {last:.4g}")
        return self._change(slab=(axis, first, last))

    def _add_clips(self) -> None:
        low, high = self.layer.box
        self._ends: list[Any] = []
        note(words=f"clip box [{self.unit}]" if self.unit else "clip box")
        with nicegui().element("div").classes("recon-fields"):
            self._clips = [
                self._add_clip(axis, float(low[axis]), float(high[axis])) for axis in range(3)
            ]

    def _add_clip(self, axis: int, low: float, high: float) -> Any:
        ui = nicegui()
        with ui.column().classes("gap-0").style("padding: 0 8px"):
            self._ends.append(note())
            step = max((high - low) / NUM_STEPS, 1e-9)
            clip = ui.range(min=low, max=high, step=step, value={"min": low, "max": high})
            testid(clip.props("dense"), self.named(f"clip-{'xyz'[axis]}"))
            clip.on_value_change(self._clip)
        self._tell_clip(axis, low, high)
        return clip

    def _tell_clip(self, axis: int, low: float, high: float) -> None:
        self._ends[axis].set_text(f"{'xyz'[axis]} {low:.4g} to {high:.4g}")

    def _clip(self) -> None:
        ends = [(clip.value["min"], clip.value["max"]) for clip in self._clips]
        for axis, (first, last) in enumerate(ends):
            self._tell_clip(axis, first, last)
        low, high = np.array(ends, np.float64).T
        margin = 1e-6 * np.maximum(high - low, 1e-9)
        self._change(low=low - margin, high=high + margin)
