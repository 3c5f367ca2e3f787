"""Depth of every pixel of a view."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales
from recon.figures.canvas import Sheet, Size
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.photo import add_bar, photo

SIZE: Size = (1000, 760)


def kept_depth(
    left: NDArray[np.uint8], depth: NDArray[np.floating], unit: str
) -> dict[str, NDArray[Any]]:
    """Arrays that `depth` is drawn from."""
    return {"left": left, "depth": depth.astype(np.float32), "unit": np.array(unit)}


def depth_image(
    left: NDArray[np.uint8],
    depth: NDArray[np.floating],
    *,
    unit: str = "world units",
    sheet: Sheet | None = None,
) -> Any:
    """Every pixel (H, W) in the colour of its depth (log scale); the image where it is unknown."""
    from matplotlib.colors import LogNorm

    sheet = sheet or Sheet.of(SIZE, fits=True)
    known = np.isfinite(depth) & (depth > 0)
    axes = photo(sheet, left, f"Depth of {known.mean():.0%} of the pixels")
    if known.any():
        low, high = scales.ends(depth[known])
        shown = axes.imshow(
            np.ma.masked_where(~known, depth), cmap=scales.disparity().reversed(),
            norm=LogNorm(low, high), interpolation="none",
        )  # fmt: skip
        scales.plain_numbers(add_bar(sheet, axes, shown, f"depth [{unit}]", depth[known]))
    sheet.fit(axes)
    return sheet.figure


def _depth(subject: Subject, sheet: Sheet) -> Any:
    kept = subject.arrays
    return depth_image(kept["left"], kept["depth"], unit=str(kept["unit"]), sheet=sheet)


def _data(subject: Subject) -> Arrays:
    return subject.arrays


DEPTH = Kind(draw=_depth, data=_data, size=SIZE, is_kept=True)
