"""A contact sheet: one small image or note for each of many runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recon.figures.canvas import ACCENT, INK, Image, Sheet, Size

CELL: Size = (420, 290)
"""Pixels of one image with its name."""
MAX_SHOWN = 400
"""More would not be legible on one sheet."""
LINE = 52
"""Characters per line of text below an image."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Print:
    """One image of a contact sheet."""

    name: str
    path: Path | None = None
    """A PNG; None if there is none to show."""
    note: str = ""
    """Text instead of the image, such as the reason why there is none."""


def columns_of(num: int) -> int:
    """Number of columns that makes a sheet of `num` images about as wide as high."""
    return max(1, int(np.ceil(np.sqrt(num * CELL[1] / CELL[0]))))


def contact(prints: Sequence[Print], *, sheet: Sheet | None = None) -> Any:
    """Images in rows, each below its name.

    Parameters
    ----------
    prints : sequence of Print
        The first `MAX_SHOWN` are shown.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    shown = prints[:MAX_SHOWN]
    columns = columns_of(len(shown))
    rows = max(1, -(-len(shown) // columns))
    sheet = sheet or Sheet.of((CELL[0] * columns, CELL[1] * rows))
    for number, one in enumerate(shown):
        axes = sheet.axes(at=(rows, columns, number + 1))
        axes.set_axis_off()
        size = min(sheet.font_size, 8.0)
        axes.set_title(one.name[:LINE], color=INK, fontsize=size, loc="left", y=1.0)
        image = None if one.path is None else thumbnail(one.path)
        if image is not None:
            axes.imshow(image, interpolation="antialiased")
        else:
            axes.text(0.0, 0.9, _wrapped(one.note), color=ACCENT, fontsize=size, va="top")
    return sheet.figure


def thumbnail(path: Path) -> Image | None:
    """A PNG, subsampled to about the shown size; None if it cannot be read."""
    from matplotlib.image import imread

    try:
        image = np.asarray(imread(path, format="png"))
    except (OSError, ValueError, SyntaxError):
        return None
    step = max(1, min(image.shape[0] // CELL[1], image.shape[1] // CELL[0]))
    levels: Image = np.rint(255 * image[::step, ::step, :3]).astype(np.uint8)
    return levels


def _wrapped(text: str) -> str:
    import textwrap

    return "\n".join(textwrap.wrap(text, LINE)[:8])
