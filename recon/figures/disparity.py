"""Disparity of the matched points, or of every pixel, drawn on the left image."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import INK, Image, Size, new_figure, to_image
from recon.figures.matching import draw_points, image
from recon.records import Matches

SIZE: Size = (1000, 760)


def disparity(left: NDArray[np.uint8], matches: Matches, size: Size = SIZE) -> Image:
    """Every matched point in the colour of its disparity, over a pale left image."""
    figure = new_figure(size)
    axes = image(figure, 111, left, f"Disparity of {len(matches)} matched points")
    dots = draw_points(axes, matches.points_px, matches.disparity_px, "turbo")
    if len(matches):
        _add_bar(figure, axes, dots)
    return to_image(figure)


def dense(left: NDArray[np.uint8], disparity_px: NDArray[np.floating], size: Size = SIZE) -> Image:
    """Every pixel in the colour of its disparity; the pale left image where it is unknown."""
    figure = new_figure(size)
    known = np.isfinite(disparity_px)
    axes = image(figure, 111, left, f"Disparity of {known.mean():.0%} of the pixels")
    shown = axes.imshow(np.ma.masked_where(~known, disparity_px), cmap="turbo")
    if known.any():
        _add_bar(figure, axes, shown)
    return to_image(figure)


def _add_bar(figure: Any, axes: Any, coloured: Any) -> None:
    """What the colours stand for, beside the image."""
    bar = figure.colorbar(coloured, ax=axes, shrink=0.75, pad=0.01)
    bar.set_label("disparity [px]", color=INK, fontsize=9)
