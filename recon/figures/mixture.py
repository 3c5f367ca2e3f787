"""The von Mises matcher's model of correct pairs (thesis figure 17)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, FAINT, INK, Sheet, Size

Array = NDArray[np.float64]
SIZE: Size = (1300, 420)

_NUM_BINS = 60
"""Number of bins of the histogram of measured phases, over a full turn."""


def mixture(
    phases_rad: Array,
    densities: Sequence[Array],
    measured_rad: Sequence[Array],
    titles: Sequence[str],
    *,
    sheet: Sheet | None = None,
) -> Any:
    """The fitted density of phase differences beside the measured ones, one panel per scale.

    Parameters
    ----------
    phases_rad : (N,)
        Phases at which the densities are sampled, -pi to pi.
    densities : sequence of (B, N)
        A scale's densities, from dissimilar magnitudes (first) to similar ones (last).
    measured_rad : sequence of (M,)
        A scale's phase differences of matched pairs.
    titles : sequence of str
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE)
    edges = np.linspace(-np.pi, np.pi, _NUM_BINS + 1)
    panels = zip(densities, measured_rad, titles, strict=True)
    for number, (curves, measured, title) in enumerate(panels, start=1):
        axes = sheet.axes(title, "phase difference [rad]", "density", (1, len(titles), number))
        axes.hist(
            measured, bins=edges, density=bool(len(measured)), color=FAINT, label="right pairs"
        )
        for place, curve in enumerate(curves):
            share = (place + 1) / len(curves)
            label = "model: like (dark) to unlike magnitudes" if share == 1.0 else None
            axes.plot(
                phases_rad, curve, color=ACCENT, alpha=0.15 + 0.85 * share, lw=1.2, label=label
            )
        axes.axhline(1.0 / (2.0 * np.pi), color=INK, lw=0.8, ls=":", label="chance")
    _add_legend(sheet, axes)
    return sheet.figure


def _add_legend(sheet: Sheet, axes: Any) -> None:
    """Add one legend below all panels."""
    drawn, words = axes.get_legend_handles_labels()
    sheet.figure.legend(
        drawn, words, loc="outside lower center", ncols=len(words), frameon=False,
        fontsize=0.9 * sheet.font_size,
    )  # fmt: skip
