"""Matches held against the truth: error map, one scale against three, fine tuning along an edge."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, FAINT, INK, Image, Size, new_axes, new_figure, to_image
from recon.records import Matches

Array = NDArray[np.float64]
WIDE: Size = (1400, 620)

MAX_ERROR_PX = 2.0
"""End of the colour scale of errors."""


def error_map(
    left: NDArray[np.uint8], matches: Matches, truth_px: Array, size: Size = WIDE
) -> Image:
    """Disparity beside its error, every judged point in the colour of |error|.

    Parameters
    ----------
    left : (H, W) or (H, W, 3) uint8
    matches : Matches
    truth_px : (H, W)
        True disparity of the left image, NaN = unknown.
    """
    figure = new_figure(size)
    u, v = np.rint(matches.points_px).astype(np.int64).T
    error = np.abs(matches.disparity_px - truth_px[v, u])
    judged = np.isfinite(error)
    wrong = float((error[judged] > 1.0).mean()) if judged.any() else 0.0
    at = matches.points_px
    dots = draw_points(image(figure, 121, left, "Disparity"), at, matches.disparity_px, "turbo")
    figure.colorbar(dots, ax=figure.axes[0], shrink=0.7).set_label("px", color=INK)
    axes = image(figure, 122, left, f"Error: {wrong:.2%} of {judged.sum()} are over 1 px")
    dots = draw_points(axes, at[judged], np.minimum(error[judged], MAX_ERROR_PX), "inferno_r")
    figure.colorbar(dots, ax=axes, shrink=0.7).set_label("|error|, px", color=INK)
    return to_image(figure)


def side_by_side(left: NDArray[np.uint8], found: Mapping[str, Matches], size: Size = WIDE) -> Image:
    """Several sets of matches of one image, in one scale of colours (thesis figure 16)."""
    figure = new_figure(size)
    values = np.concatenate([matches.disparity_px for matches in found.values()])
    span = {"vmin": values.min(initial=0.0), "vmax": values.max(initial=1.0)}
    for number, (title, matches) in enumerate(found.items(), start=1):
        axes = image(figure, (1, len(found), number), left, f"{title}: {len(matches)} pairs")
        draw_points(axes, matches.points_px, matches.disparity_px, "turbo", **span)
    return to_image(figure)


def tuning(
    integer: Matches, tuned: Matches, truth_px: Array, row: int, size: Size = (1000, 520)
) -> Image:
    """Disparity before and after fine tuning along one image row (thesis figures 10, 15)."""
    figure = new_figure(size)
    axes = new_axes(figure, f"Fine tuning along row {row}", "u [px]", "disparity [px]")
    columns = np.arange(truth_px.shape[1])
    axes.plot(columns, truth_px[row], color=FAINT, lw=2, label="truth")
    for matches, style, name in ((integer, "s", "matched"), (tuned, ".", "fine tuned")):
        here = np.rint(matches.points_px[:, 1]) == row
        colour = INK if style == "s" else ACCENT
        axes.plot(
            matches.points_px[here, 0], matches.disparity_px[here], style, ms=4, color=colour,
            mfc="none" if style == "s" else colour, label=name,
        )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)
    return to_image(figure)


def image(figure: Any, at: Any, left: NDArray[np.uint8], title: str) -> Any:
    """Axes with a pale image, for points in strong colours."""
    axes = new_axes(figure, title, at=at)
    grey = left.mean(axis=2) if left.ndim == 3 else left
    axes.imshow(grey * 0.35 + 165.0, cmap="gray", vmin=0, vmax=255)
    axes.set_xticks([])
    axes.set_yticks([])
    return axes


def draw_points(axes: Any, at: Array, values: Array, cmap: str, **span: float) -> Any:
    """Dots at image points (N, 2) in the colours of their values."""
    return axes.scatter(at[:, 0], at[:, 1], c=values, s=2.5, cmap=cmap, linewidths=0, **span)
