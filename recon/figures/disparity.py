"""Disparity of the matched points, drawn on the left image."""

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import INK, Image, Size, new_axes, new_figure, to_image
from recon.records import Matches

SIZE: Size = (1000, 760)


def disparity(left: NDArray[np.uint8], matches: Matches, size: Size = SIZE) -> Image:
    """Every matched point in the colour of its disparity, over a pale left image."""
    figure = new_figure(size)
    axes = new_axes(figure, f"Disparity of {len(matches)} matched points")
    grey = left.mean(axis=2) if left.ndim == 3 else left
    axes.imshow(grey * 0.35 + 165.0, cmap="gray", vmin=0, vmax=255)
    points = axes.scatter(
        matches.points_px[:, 0], matches.points_px[:, 1], c=matches.disparity_px, s=3.0,
        cmap="turbo", linewidths=0,
    )  # fmt: skip
    axes.set_xticks([])
    axes.set_yticks([])
    if len(matches):
        bar = figure.colorbar(points, ax=axes, shrink=0.75, pad=0.01)
        bar.set_label("disparity [px]", color=INK, fontsize=9)
    return to_image(figure)
