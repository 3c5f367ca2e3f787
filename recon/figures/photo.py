"""An image as background: dark and grey, so that strong colours stand out."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales
from recon.figures.canvas import Sheet

Array = NDArray[np.float64]

POINT_SHARE = 0.00173
"""Width of a point, as a share of the image's width in the figure."""


def photo(sheet: Sheet, left: NDArray[np.uint8], title: str, at: Any = 111) -> Any:
    """Axes with a dimmed image, for coloured points."""
    axes = sheet.axes(title, at=at)
    grey = left.mean(axis=2) if left.ndim == 3 else left
    axes.imshow(grey * 0.45, cmap="gray", vmin=0, vmax=255, interpolation="none")
    return without_ticks(axes)


def plain(sheet: Sheet, left: NDArray[np.uint8], title: str) -> Any:
    """Axes with an image as it is."""
    axes = sheet.axes(title)
    axes.imshow(left, cmap="gray", vmin=0, vmax=255, interpolation="none")
    return without_ticks(axes)


def without_ticks(axes: Any) -> Any:
    """The axes, without pixel numbers."""
    axes.set_xticks([])
    axes.set_yticks([])
    return axes


def points(sheet: Sheet, axes: Any, at: Array, values: Array, **look: Any) -> Any:
    """Dots at image points (N, 2) in the colours of their values."""
    columns = int(np.asarray(axes.get_gridspec().ncols))
    width_px = max(1.6, POINT_SHARE * sheet.size[0] / columns)
    size = (width_px * 72.0 / sheet.style.dpi) ** 2
    low, high = scales.ends(values)
    span = {"vmin": low, "vmax": high} | look
    return axes.scatter(at[:, 0], at[:, 1], c=values, s=size, linewidths=0, **span)


def add_bar(sheet: Sheet, axes: Any, drawn: Any, label: str, values: Array) -> Any:
    """Add a colour bar, with arrows if values lie beyond it."""
    extend = scales.beyond(values, *drawn.get_clim())
    return sheet.colour_bar(drawn, axes, label, extend=extend)
