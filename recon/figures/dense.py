"""Every pixel judged: where it errs, what its sigma is worth, and what can be had for it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import ACCENT, INK, Image, Size, new_axes, new_figure, to_image
from recon.figures.matching import image
from recon.records import DisparityMap

SIZE: Size = (1400, 480)
_LARGEST_PX = 2.0
"""Errors as large as this have the last colour."""
_NUM_BINS = 12


def dense_errors(
    left: NDArray[np.uint8],
    found: Mapping[str, DisparityMap],
    truth_px: NDArray[np.floating],
    size: Size = SIZE,
) -> Image:
    """The error of every pixel, method by method; the pale image where nothing was found."""
    figure = new_figure(size)
    for number, (name, one) in enumerate(found.items(), start=1):
        axes = image(figure, (1, len(found), number), left, f"Errors of {name}")
        error = np.abs(one.disparity_px - truth_px)
        shown = axes.imshow(np.ma.masked_invalid(error), cmap="magma_r", vmin=0.0, vmax=_LARGEST_PX)
    bar = figure.colorbar(shown, ax=figure.axes, shrink=0.75, pad=0.01)
    bar.set_label("error [px]", color=INK, fontsize=9)
    return to_image(figure)


def dense_sigmas(
    found: Mapping[str, DisparityMap], truth_px: NDArray[np.floating], size: Size = SIZE
) -> Image:
    """Error against sigma, and the share of right pixels as the least sure ones are cut."""
    figure = new_figure(size)
    law = new_axes(figure, "Errors of pixels of one sigma", "sigma [px]", "68 % error [px]", 121)
    cut = new_axes(figure, "Right, as sigma is cut", "covered [%]", "right, of covered [%]", 122)
    for name, one in found.items():
        covered = np.isfinite(truth_px) & one.valid_mask
        error = np.abs(one.disparity_px - truth_px)[covered]
        sigma = one.sigma_px[covered]
        if not error.size:
            continue
        order = np.argsort(sigma, kind="stable")
        right = np.cumsum(error[order] <= 1) / np.arange(1, error.size + 1)
        share = np.arange(1, error.size + 1) / np.isfinite(truth_px).sum()
        some = np.unique(np.linspace(error.size // 20, error.size - 1, 200).astype(int))
        cut.plot(100 * share[some], 100 * right[some], label=name)
        if np.ptp(sigma) > 0:
            parts = np.array_split(order, _NUM_BINS)
            x = [np.median(sigma[part]) for part in parts if len(part)]
            law.loglog(x, [np.quantile(error[p], 0.683) for p in parts if len(p)], "o-", label=name)
    low, high = 0.03, 8.0
    law.plot([low, high], [low, high], color=ACCENT, linewidth=1, label="honest")
    for axes in (law, cut):
        axes.legend(frameon=False, fontsize=8)
    return to_image(figure)
