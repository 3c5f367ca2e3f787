"""How often labels are right, and whether probabilities mean what they say."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, FAINT, INK, Image, Size, new_axes, new_figure, to_image

SIZE: Size = (720, 620)
NUM_BINS = 10


def confusion_matrix(confusion: Mapping[str, Mapping[str, int]], size: Size = SIZE) -> Image:
    """Counts of what true objects (rows) were taken for (columns)."""
    rows = sorted(confusion)
    columns = sorted({*rows, *(found for row in confusion.values() for found in row)})
    counts = np.array([[confusion[true].get(found, 0) for found in columns] for true in rows])
    figure = new_figure(size)
    axes = new_axes(figure, "True objects (rows) and what they were taken for", "found", "true")
    axes.imshow(counts / np.maximum(counts.sum(axis=1, keepdims=True), 1), cmap="Greens", vmax=1.6)
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(rows)), rows)
    for (row, column), count in np.ndenumerate(counts):
        axes.text(column, row, str(count), ha="center", va="center", color=INK, fontsize=12)
    return to_image(figure)


def reliability(
    probability: NDArray[np.float64], is_right: NDArray[np.bool_], size: Size = SIZE
) -> Image:
    """Share of right labels over the probability they were given, with the number of each."""
    figure = new_figure(size)
    axes = new_axes(figure, "Do probabilities mean what they say?", "probability", "share right")
    axes.plot([0, 1], [0, 1], color=FAINT, lw=1)
    bins = np.minimum((probability * NUM_BINS).astype(int), NUM_BINS - 1)
    for number in np.unique(bins):
        here = bins == number
        place = probability[here].mean(), is_right[here].mean()
        axes.plot(*place, "o", color=ACCENT, ms=8)
        axes.annotate(str(here.sum()), place, xytext=(8, -4), textcoords="offset points", color=INK)
    axes.set(xlim=(-0.02, 1.05), ylim=(-0.02, 1.05))
    return to_image(figure)
