"""A contact sheet: one small image or note for each of many runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recon.figures.canvas import ACCENT, INK, Image, Sheet, Size

CELL: Size = (420, 290)
"""Pixels of one image with its name."""
MARGIN = 6
NAME_HEIGHT = 24
"""Pixels of a name above its image."""
MAX_SHOWN = 400
"""More would not be legible on one sheet."""
LINE = 52
"""Characters per line of text below an image."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Print:
    """One image of a contact sheet."""

    name: str
    image: Image | None = None
    """(H, W, 3), as `thumbnail` gives it; None if there is none to show."""
    note: str = ""
    """Text instead of the image, such as the reason why there is none."""


def columns_of(num: int) -> int:
    """Number of columns that makes a sheet of `num` images about as wide as high."""
    return max(1, int(np.ceil(np.sqrt(num * CELL[1] / CELL[0]))))


def contact(prints: Sequence[Print]) -> Any:
    """Images in rows, each below its name.

    Parameters
    ----------
    prints : sequence of Print
        The first `MAX_SHOWN` are shown.

    Returns
    -------
    matplotlib Figure
    """
    shown = prints[:MAX_SHOWN]
    columns = columns_of(len(shown))
    rows = max(1, -(-len(shown) // columns))
    sheet = Sheet.of((CELL[0] * columns, CELL[1] * rows))
    sheet.place_by_hand()
    axes = sheet.figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    size = min(sheet.font_size, 8.0)
    # One image of all: axes for each would take most of the time.
    mosaic = np.full((CELL[1] * rows, CELL[0] * columns, 3), 255, np.uint8)
    for number, one in enumerate(shown):
        top, left = CELL[1] * (number // columns), CELL[0] * (number % columns)
        axes.text(left + MARGIN, top + MARGIN, one.name[:LINE], color=INK, fontsize=size, va="top")
        if one.image is not None:
            height, width = one.image.shape[:2]
            inner = top + NAME_HEIGHT, left + (CELL[0] - width) // 2
            mosaic[inner[0] : inner[0] + height, inner[1] : inner[1] + width] = one.image
        else:
            axes.text(left + MARGIN, top + NAME_HEIGHT, _wrapped(one.note), color=ACCENT,
                      fontsize=size, va="top")  # fmt: skip
    axes.imshow(mosaic, interpolation="none", aspect="auto")
    return sheet.figure


def thumbnail(path: Path) -> Image | None:
    """A PNG (H, W, 3), made to fit below a name; None if it cannot be read."""
    import PIL.Image

    try:
        with PIL.Image.open(path, formats=("PNG",)) as stored:
            image = stored.convert("RGB")
    except (OSError, ValueError, SyntaxError):
        return None
    image.thumbnail((CELL[0] - 2 * MARGIN, CELL[1] - NAME_HEIGHT - MARGIN), reducing_gap=2.0)
    return np.asarray(image)


def _wrapped(text: str) -> str:
    import textwrap

    return "\n".join(textwrap.wrap(text, LINE)[:8])
