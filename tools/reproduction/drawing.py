"""Figures of the page: coloured points over images, side by side."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from recon.records import Features, Matches

SCALE = "viridis"
"""Colours that the colour-blind can tell apart."""
TURNS = "twilight"
"""A scale without ends, for directions."""


def sheet(number: int, width: float = 4.2, height: float = 3.4) -> tuple[Figure, list[Any]]:
    """Make a figure with axes in a row."""
    figure = Figure(figsize=(width * number, height), layout="constrained", dpi=90)
    return figure, list(np.atleast_1d(figure.subplots(1, number)))


def show(axes: Any, image: NDArray[np.uint8], title: str) -> None:
    """Show an image without ticks."""
    axes.imshow(image, cmap="gray" if image.ndim == 2 else None)
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()


def scatter(
    axes: Any, shape: Sequence[int], points_px: Any, values: Any, title: str, scale: str, unit: str
) -> None:
    """Draw coloured points on white, with a colour bar."""
    dots = axes.scatter(*points_px.T, c=values, s=1.0, cmap=scale, linewidths=0)
    axes.set(xlim=(0, shape[1]), ylim=(shape[0], 0), aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, fontsize=9)
    axes.figure.colorbar(dots, ax=axes, shrink=0.8, label=unit)


def features_over(axes: Any, features: Features, title: str) -> None:
    """Draw feature points coloured by orientation."""
    degrees = np.degrees(features.orientation_rad)
    shape = features.grey.shape
    scatter(axes, shape, features.points_px, degrees, title, TURNS, "orientation, degrees")


def disparity_over(axes: Any, shape: Sequence[int], matches: Matches, title: str) -> None:
    """Draw matches coloured by disparity."""
    scatter(axes, shape, matches.points_px, matches.disparity_px, title, SCALE, "disparity, px")
