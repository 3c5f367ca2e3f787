"""Disparity of the matched points, or of every pixel, drawn on the left image."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales
from recon.figures.canvas import Sheet, Size
from recon.figures.photo import add_bar, photo, points

Array = NDArray[np.float64]
SIZE: Size = (1000, 760)
LABEL = "disparity [px]"


def disparity(
    left: NDArray[np.uint8], points_px: Array, disparity_px: Array, *, sheet: Sheet | None = None
) -> Any:
    """Every matched point (M, 2) in the colour of its disparity (M,), over the left image."""
    sheet = sheet or Sheet.of(SIZE, fits=True)
    axes = photo(sheet, left, f"Disparity of {len(points_px):,} matched points")
    if len(points_px):
        dots = points(sheet, axes, points_px, disparity_px, cmap=scales.disparity())
        add_bar(sheet, axes, dots, LABEL, disparity_px)
    sheet.trim(axes)
    return sheet.figure


def dense(
    left: NDArray[np.uint8], disparity_px: NDArray[np.floating], *, sheet: Sheet | None = None
) -> Any:
    """Every pixel (H, W) in the colour of its disparity; the left image where it is unknown."""
    sheet = sheet or Sheet.of(SIZE, fits=True)
    known = np.isfinite(disparity_px)
    axes = photo(sheet, left, f"Disparity of {known.mean():.0%} of the pixels")
    if known.any():
        low, high = scales.ends(disparity_px)
        shown = axes.imshow(
            np.ma.masked_where(~known, disparity_px), cmap=scales.disparity(), vmin=low, vmax=high,
            interpolation="none",
        )  # fmt: skip
        add_bar(sheet, axes, shown, LABEL, disparity_px[known])
    sheet.trim(axes)
    return sheet.figure
