"""The shown rows of a layer: thresholds, a box, and a limit for fast drawing."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.app.layers import Layer

Array = NDArray[np.float64]

AT_LEAST = ("count", "num_views", "views", "weight", "hits")
AT_MOST = ("sigma",)
"""Columns with sliders for a lower bound, and for an upper bound."""

MOST_AT_REST = 2_000_000
MOST_MOVING = 80_000
"""Maximum number of rows drawn at rest, and while the view turns."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Filter:
    """Bounds on the shown rows."""

    least: Mapping[str, float] = field(default_factory=dict)
    most: Mapping[str, float] = field(default_factory=dict)
    low: Array | None = None
    high: Array | None = None
    """Corners (3,) of the clip box, world."""
    slab: tuple[int, float, float] | None = None
    """Axis, lower and upper limit of a slice."""

    def kept(self, layer: Layer) -> NDArray[np.bool_]:
        """(N,) mask of the rows that pass; unknown values pass."""
        kept = np.ones(len(layer), bool)
        for name, bound in self.least.items():
            if name in layer.columns:
                kept &= ~(layer.columns[name] < bound)
        for name, bound in self.most.items():
            if name in layer.columns:
                kept &= ~(layer.columns[name] > bound)
        if self.slab is not None:
            axis, first, last = self.slab
            kept &= (layer.places[:, axis] >= first) & (layer.places[:, axis] <= last)
        if self.low is not None and self.high is not None:
            kept &= ((layer.places >= self.low) & (layer.places <= self.high)).all(axis=1)
        return kept


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shown:
    """The drawn rows, and the total numbers."""

    rows: NDArray[np.int64]
    num_kept: int
    """Number of rows that pass the filter."""
    num_all: int

    def share(self, noun: str) -> str:
        """The shown share, in words."""
        drawn = 1.0 if not self.num_kept else len(self.rows) / self.num_kept
        text = f"shows {len(self.rows):,} of {self.num_all:,} {noun}"
        if len(self.rows) < self.num_kept:
            return f"{text}: {drawn:.0%} of the {self.num_kept:,} that pass, drawn at random"
        if self.num_kept < self.num_all:
            return f"{text} ({self.num_kept / self.num_all:.0%}): the others are filtered out"
        return f"{text} (100%)"


class Selection:
    """The rows of a layer that pass a filter, and those of them that are drawn.

    A drawing keeps the selection with which it began, whatever is chosen meanwhile.
    """

    def __init__(self, layer: Layer, chosen: Filter) -> None:
        self.layer = layer
        self.kept = chosen.kept(layer)
        """(N,) mask of the rows that pass."""
        self._shown: dict[int, Shown] = {}

    def shown(self, most: int) -> Shown:
        """The rows to draw: all that pass, or a random sample of `most`."""
        if most not in self._shown:
            self._shown[most] = shown(self.layer, self.kept, most)
        return self._shown[most]


def shown(layer: Layer, kept: NDArray[np.bool_], most: int) -> Shown:
    """The rows to draw: all that pass, or a random sample of `most`."""
    total = int(kept.sum())
    rows = np.flatnonzero(kept) if total <= most else layer.order[kept[layer.order]][:most]
    return Shown(rows=rows, num_kept=total, num_all=len(layer))
