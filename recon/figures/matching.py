"""Matches compared with the truth: error map, one scale or three, fine tuning along an edge."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales
from recon.figures.canvas import ACCENT, FAINT, INK, Sheet, Size
from recon.figures.photo import add_bar, photo, points

Array = NDArray[np.float64]
WIDE: Size = (1400, 620)
TUNING_SIZE: Size = (1000, 520)

MAX_ERROR_PX = 2.0
"""End of the colour scale of errors."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """Matched points to be drawn."""

    points_px: Array
    """(M, 2) in the left image."""
    disparity_px: Array
    """(M,)"""

    def __len__(self) -> int:
        return len(self.points_px)


def error_map(
    left: NDArray[np.uint8], matches: Drawn, truth_px: Array, *, sheet: Sheet | None = None
) -> Any:
    """Disparity beside its error, with every evaluated point in the colour of |error|.

    Parameters
    ----------
    left : (H, W) or (H, W, 3) uint8
    matches : Drawn
    truth_px : (H, W)
        True disparity of the left image, NaN = unknown.
    sheet : Sheet, optional

    Returns
    -------
    matplotlib Figure
    """
    sheet = sheet or Sheet.of(WIDE)
    at = matches.points_px
    u, v = np.rint(at).astype(np.int64).T
    error = np.abs(matches.disparity_px - truth_px[v, u])
    judged = np.isfinite(error)
    wrong = float((error[judged] > 1.0).mean()) if judged.any() else 0.0
    axes = photo(sheet, left, f"Disparity of {len(matches):,} points", (1, 2, 1))
    dots = points(sheet, axes, at, matches.disparity_px, cmap=scales.disparity())
    add_bar(sheet, axes, dots, "disparity [px]", matches.disparity_px)
    title = f"Error: {wrong:.2%} of {judged.sum():,} are over 1 px"
    axes = photo(sheet, left, title, (1, 2, 2))
    dots = points(
        sheet, axes, at[judged], error[judged], cmap=scales.error(), vmin=0.0, vmax=MAX_ERROR_PX
    )
    add_bar(sheet, axes, dots, "|error| [px]", error[judged])
    return sheet.figure


def side_by_side(
    left: NDArray[np.uint8], found: Mapping[str, Drawn], *, sheet: Sheet | None = None
) -> Any:
    """Several sets of matches of one image, with a common colour scale (thesis figure 16)."""
    sheet = sheet or Sheet.of(WIDE)
    values = np.concatenate([matches.disparity_px for matches in found.values()])
    low, high = scales.ends(values)
    for number, (title, matches) in enumerate(found.items(), start=1):
        heading = f"{title}: {len(matches):,} points"
        axes = photo(sheet, left, heading, (1, len(found), number))
        dots = points(
            sheet, axes, matches.points_px, matches.disparity_px, cmap=scales.disparity(),
            vmin=low, vmax=high,
        )  # fmt: skip
    add_bar(sheet, axes, dots, "disparity [px]", values)
    return sheet.figure


def tuning(
    integer: Drawn, tuned: Drawn, truth_px: Array, row: int, *, sheet: Sheet | None = None
) -> Any:
    """Disparity before and after fine tuning along one image row (thesis figures 10, 15)."""
    sheet = sheet or Sheet.of(TUNING_SIZE)
    axes = sheet.axes(f"Fine tuning along row {row}", "u [px]", "disparity [px]")
    columns = np.arange(truth_px.shape[1])
    axes.plot(columns, truth_px[row], color=FAINT, lw=2, label="truth")
    for matches, style, name in ((integer, "s", "matched"), (tuned, ".", "fine tuned")):
        here = np.rint(matches.points_px[:, 1]) == row
        colour = INK if style == "s" else ACCENT
        axes.plot(
            matches.points_px[here, 0], matches.disparity_px[here], style, ms=4, color=colour,
            mfc="none" if style == "s" else colour, label=name,
        )  # fmt: skip
    axes.legend(frameon=False, fontsize=0.9 * sheet.font_size)
    return sheet.figure
