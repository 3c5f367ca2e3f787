"""The sheet that flat figures are drawn on; the same image gives the same bytes as PNG."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.files import atomic_path

Image = NDArray[np.uint8]
Size = tuple[int, int]
"""Width and height in pixels."""

DPI = 100
PAPER = "#fbfaf7"
INK = "#2b2b2b"
FAINT = "#b9b4a8"
ACCENT = "#c2452d"


def new_figure(size: Size) -> Any:
    """An empty matplotlib figure of `size` pixels in the house's colours."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(
        figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI, facecolor=PAPER, layout="constrained"
    )
    FigureCanvasAgg(figure)
    return figure


def new_axes(figure: Any, title: str, xlabel: str = "", ylabel: str = "", at: Any = 111) -> Any:
    """Axes with a title and quiet lines."""
    axes = figure.add_subplot(*np.atleast_1d(at).tolist())
    axes.set_facecolor(PAPER)
    axes.set_title(title, color=INK, fontsize=11, loc="left")
    axes.set_xlabel(xlabel, color=INK, fontsize=9)
    axes.set_ylabel(ylabel, color=INK, fontsize=9)
    axes.tick_params(colors=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_color(FAINT)
    return axes


def to_image(figure: Any) -> Image:
    """The pixels (H, W, 3) of a figure."""
    figure.canvas.draw()
    pixels: Image = np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()
    return pixels


def save_png(image: Image, path: Path) -> None:
    """Write an image (H, W, 3) as PNG, whole, without a date or a program's name in it."""
    from matplotlib.image import imsave

    with atomic_path(path) as part:
        # None takes the entry out; the stubs know strings only.
        nameless = {"Software": None}
        imsave(part, image, format="png", metadata=nameless)  # type: ignore[arg-type]
