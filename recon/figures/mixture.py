"""What right pairs look like to the von Mises matcher (thesis figure 17)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, INK, Image, Size, new_axes, new_figure, to_image

Array = NDArray[np.float64]
SIZE: Size = (1300, 420)


def mixture(
    phases_rad: Array, densities: Sequence[Array], titles: Sequence[str], size: Size = SIZE
) -> Image:
    """The fitted density of phase differences, one panel a scale.

    Parameters
    ----------
    phases_rad : (N,)
        Where the densities were taken, -pi to pi.
    densities : sequence of (B, N)
        A scale's densities for unlike magnitudes (first) to like ones (last).
    titles : sequence of str
    """
    figure = new_figure(size)
    for number, (curves, title) in enumerate(zip(densities, titles, strict=True), start=1):
        axes = new_axes(figure, title, "phase difference [rad]", at=(1, len(titles), number))
        for place, curve in enumerate(curves):
            share = (place + 1) / len(curves)
            axes.plot(phases_rad, curve, color=ACCENT, alpha=0.15 + 0.85 * share, lw=1.2)
        axes.axhline(1.0 / (2.0 * np.pi), color=INK, lw=0.6, ls=":")
    return to_image(figure)
