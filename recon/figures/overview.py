"""An overview of a run: the map with names, a camera image, its matches, the floor."""

from collections.abc import Callable, Sequence
from typing import Any

from recon.figures.canvas import Sheet, Size

SIZE: Size = (1700, 1000)
PANEL_FONT = 0.8
"""Font size of the small figures, relative to that of the large one."""
Panel = Callable[[Sheet], Any]
"""Draws one figure onto a given sheet."""


def overview(
    main: Panel,
    others: Sequence[Panel],
    *,
    heights: Sequence[float] | None = None,
    sheet: Sheet | None = None,
) -> Any:
    """One large figure, and others in a column to its right, on one sheet.

    Parameters
    ----------
    main : callable
        Draws the large one.
    others : sequence of callable
    heights : sequence of float, optional
        Relative heights of the others.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(SIZE)
    if not others:
        main(sheet)
        return sheet.figure
    large, column = sheet.panels(1, 2, width_ratios=(1.65, 1.0), wspace=0.02)[0]
    main(large)
    panels = column.panels(len(others), 1, font_share=PANEL_FONT, height_ratios=heights)
    for draw, panel in zip(others, panels[:, 0], strict=True):
        draw(panel)
    return sheet.figure
