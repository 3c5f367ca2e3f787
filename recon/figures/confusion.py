"""Confusion of labels, and reliability of their probabilities."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, FAINT, INK, Sheet, Size

SIZE: Size = (720, 620)
NUM_BINS = 10
DARK = 0.6
"""Share of a row above which its cell is so dark that its text is white."""


def confusion_matrix(
    true: Sequence[str], found: Sequence[str], *, sheet: Sheet | None = None
) -> Any:
    """Counts of true labels (rows) and found labels (columns), from one entry per object."""
    sheet = sheet or Sheet.of(SIZE)
    rows = sorted(set(true))
    columns = sorted({*rows, *found})
    counts = np.zeros((len(rows), len(columns)), np.int64)
    at = [rows.index(name) for name in true], [columns.index(name) for name in found]
    np.add.at(counts, at, 1)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes = sheet.axes("True objects (rows) and their found labels", "found", "true")
    drawn = axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0)
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(rows)), rows)
    for (row, column), count in np.ndenumerate(counts):
        colour = "white" if share[row, column] > DARK else INK
        axes.text(column, row, str(count), ha="center", va="center", color=colour,
                  fontsize=1.2 * sheet.font_size)  # fmt: skip
    sheet.colour_bar(drawn, axes, "share of the row")
    return sheet.figure


def reliability(
    probability: NDArray[np.float64], is_right: NDArray[np.bool_], *, sheet: Sheet | None = None
) -> Any:
    """Share of correct labels over their assigned probability, with the number of objects."""
    sheet = sheet or Sheet.of(SIZE)
    axes = sheet.axes("Reliability of the probabilities", "probability", "share correct")
    axes.plot([0, 1], [0, 1], color=FAINT, lw=1, label="share correct = probability")
    bins = np.minimum((probability * NUM_BINS).astype(int), NUM_BINS - 1)
    for number in np.unique(bins):
        here = bins == number
        place = probability[here].mean(), is_right[here].mean()
        axes.plot(*place, "o", color=ACCENT, ms=8)
        count = int(here.sum())
        # Inside the axes: to the left of what lies on the right.
        side = -1 if place[0] > 0.5 else 1
        axes.annotate(
            f"{count} object{'' if count == 1 else 's'}", place, xytext=(9 * side, 0),
            textcoords="offset points", color=INK, fontsize=0.9 * sheet.font_size, va="center",
            ha="right" if side < 0 else "left",
        )  # fmt: skip
    axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03), aspect="equal")
    axes.legend(frameon=False, loc="upper left", fontsize=0.9 * sheet.font_size)
    return sheet.figure
