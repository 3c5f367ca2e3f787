"""Evaluation of dense disparities: errors, calibration of sigma, accuracy over coverage."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.figures import scales
from recon.figures.canvas import FAINT, SERIES, Sheet, Size
from recon.figures.kinds import Arrays, Kind, Subject
from recon.figures.matching import MAX_ERROR_PX
from recon.figures.photo import add_bar, photo
from recon.records import DisparityMap

SIZE: Size = (1500, 460)
_NUM_BINS = 12
_ONE_SIGMA = 0.683


def kept_dense(
    left: NDArray[np.uint8], found: Mapping[str, DisparityMap], truth_px: NDArray[np.floating]
) -> dict[str, NDArray[Any]]:
    """Arrays that `dense_errors` and `dense_sigmas` are drawn from: disparities by matcher."""
    kept: dict[str, NDArray[Any]] = {"left": left, "truth_px": truth_px.astype(np.float32)}
    for name, one in found.items():
        kept |= {f"{name}/disparity_px": one.disparity_px, f"{name}/sigma_px": one.sigma_px}
    return kept


def _maps(kept: Arrays) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Disparity and sigma by matcher, as stored by `kept_dense`."""
    names = [key.removesuffix("/sigma_px") for key in kept if key.endswith("/sigma_px")]
    return {name: (kept[f"{name}/disparity_px"], kept[f"{name}/sigma_px"]) for name in names}


def _errors(subject: Subject, sheet: Sheet) -> Any:
    """The error of every pixel, by matcher; the image where no disparity was found."""
    kept = subject.arrays
    maps = _maps(kept)
    for number, (name, (disparity, _)) in enumerate(maps.items(), start=1):
        error = np.abs(disparity - kept["truth_px"])
        known = np.isfinite(error)
        axes = photo(sheet, kept["left"], f"Errors of {name}", (1, len(maps), number))
        shown = axes.imshow(
            np.ma.masked_where(~known, error), cmap=scales.ERROR, vmin=0.0, vmax=MAX_ERROR_PX,
            interpolation="none",
        )  # fmt: skip
        if number == len(maps):
            add_bar(sheet, axes, shown, "|error| [px]", error[known])
    return sheet.figure


def _sigmas(subject: Subject, sheet: Sheet) -> Any:
    """Error over sigma, and accuracy over coverage as the most uncertain pixels are removed."""
    truth = subject.arrays["truth_px"]
    law = sheet.axes("Errors of pixels of equal sigma", "sigma [px]", "68 % of errors [px]", 121)
    cut = sheet.axes("Accuracy over coverage", "covered [%]", "correct, of the covered [%]", 122)
    for axes in (law, cut):
        axes.set_prop_cycle(color=SERIES)
    for name, (disparity, sigma) in _maps(subject.arrays).items():
        covered = np.isfinite(truth) & np.isfinite(disparity)
        if covered.any():
            error = np.abs(disparity - truth)[covered]
            _add_curve(cut, name, error, sigma[covered], int(np.isfinite(truth).sum()))
            _add_law(law, name, error, sigma[covered])
    drawn = np.concatenate([np.empty(0), *(np.ravel(line.get_data()) for line in law.get_lines())])
    if len(drawn):
        law.loglog(*2 * [[drawn.min(), drawn.max()]], color=FAINT, zorder=0, label="calibrated")
        for axis in (law.xaxis, law.yaxis):
            scales.number_plainly(axis, (drawn.min(), drawn.max()))
    for axes in (law, cut):
        axes.legend(frameon=False, fontsize=0.9 * sheet.font_size)
    return sheet.figure


def _add_curve(
    axes: Any, name: str, error: NDArray[Any], sigma: NDArray[Any], num_known: int
) -> None:
    order = np.argsort(sigma, kind="stable")
    count = np.arange(1, error.size + 1)
    right = np.cumsum(error[order] <= 1) / count
    some = np.unique(np.linspace(error.size // 20, error.size - 1, 200).astype(np.int64))
    if np.ptp(sigma) > 0:
        axes.plot(100 * count[some] / num_known, 100 * right[some], label=name)
    else:  # no order in which to remove pixels
        axes.plot(100 * count[-1] / num_known, 100 * right[-1], "o", label=name)


def _add_law(axes: Any, name: str, error: NDArray[Any], sigma: NDArray[Any]) -> None:
    if not np.ptp(sigma) > 0:
        return
    parts = np.array_split(np.argsort(sigma, kind="stable"), _NUM_BINS)
    bins = [part for part in parts if len(part)]
    errors = [max(float(np.quantile(error[part], _ONE_SIGMA)), 1e-3) for part in bins]
    axes.loglog([float(np.median(sigma[part])) for part in bins], errors, "o-", label=name)


ERRORS = Kind(draw=_errors, data=lambda subject: subject.arrays, size=SIZE, is_kept=True)
SIGMAS = Kind(draw=_sigmas, data=lambda subject: subject.arrays, size=SIZE, is_kept=True)
