"""Accuracy of matches compared with the true disparity (Eqs 1, 2, Tables 1 and 3)."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_shape
from recon.records import Matches

MISMATCH_PX = 1.0
"""An error larger than this is a mismatch."""

Disparity = NDArray[np.floating]


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """Metrics of one set of matches; NaN if there is nothing to count."""

    num_judged: int
    """Number of matches with known truth."""
    num_mismatches: int
    success_all: float
    """Percent of the judged matches within `MISMATCH_PX`."""
    success_nonocc: float
    """The same for matches whose left point is also visible to the right camera."""
    rms_px: float
    """Root mean square error of the judged matches (Eq 1)."""
    bad_share: float
    """Share of the judged matches that are mismatches (Eq 2)."""
    subpixel_median_px: float
    """Median error of the correct matches that are not occluded."""
    subpixel_rms_px: float
    """Their root mean square error."""

    def as_metrics(self) -> dict[str, float | int | None]:
        """The metrics by name; None if there is nothing to count."""
        return {name: None if value != value else value for name, value in asdict(self).items()}


def evaluate(
    matches: Matches,
    truth_px: Disparity,
    quantisation_px: float = 0.0,
    truth_right_px: Disparity | None = None,
) -> Evaluation:
    """Compare matches with the true disparity of the left image.

    Parameters
    ----------
    matches : Matches
    truth_px : (H, W) float
        Disparity of the left image's pixels; NaN = unknown.
    quantisation_px : float
        Quantisation step of the truth. If it is a whole pixel, refined disparities are rounded
        first, like the truth.
    truth_right_px : (H, W) float, optional
        Disparity of the right image's pixels: it tells which left pixels are occluded.

    Returns
    -------
    Evaluation
    """
    u, v = np.rint(matches.points_px).astype(np.int64).T
    seen = seen_by_both(truth_px, truth_right_px)
    return _judged(u, v, matches.disparity_px, truth_px, quantisation_px, seen)


def evaluate_map(
    disparity_px: Disparity, truth_px: Disparity, quantisation_px: float = 0.0
) -> Evaluation:
    """Compare a dense disparity (H, W), NaN = unknown, with the true one."""
    v, u = np.nonzero(np.isfinite(disparity_px))
    seen = seen_by_both(truth_px)
    return _judged(u, v, disparity_px[v, u], truth_px, quantisation_px, seen)


def _judged(
    u: NDArray[np.int64],
    v: NDArray[np.int64],
    disparity_px: Disparity,
    truth_px: Disparity,
    quantisation_px: float,
    seen: NDArray[np.bool_],
) -> Evaluation:
    height, width = truth_px.shape
    if len(u) and (u.max() >= width or v.max() >= height):
        raise InputError(
            f"truth is {width} x {height} pixels, but a match lies at ({u.max()}, {v.max()})"
        )
    truth = truth_px[v, u]
    found = np.rint(disparity_px) if quantisation_px >= 1 else disparity_px
    judged = np.isfinite(truth)
    return _evaluation(np.abs(found - truth)[judged], seen[v, u][judged])


def _evaluation(error: Disparity, seen: NDArray[np.bool_]) -> Evaluation:
    right = error <= MISMATCH_PX
    fine = error[right & seen]
    return Evaluation(
        num_judged=error.size,
        num_mismatches=int((~right).sum()),
        success_all=100 * _mean(right),
        success_nonocc=100 * _mean(right[seen]),
        rms_px=_mean(error**2) ** 0.5,
        bad_share=_mean(~right),
        subpixel_median_px=float(np.median(fine)) if fine.size else float("nan"),
        subpixel_rms_px=_mean(fine**2) ** 0.5,
    )


def _mean(values: NDArray[np.floating] | NDArray[np.bool_]) -> float:
    return float(values.mean()) if values.size else float("nan")


def seen_by_both(truth_px: Disparity, truth_right_px: Disparity | None = None) -> NDArray[np.bool_]:
    """Mask of the left pixels that are visible to the right camera.

    These are confirmed by the right truth within a pixel; without a right truth, they are not
    covered by a nearer pixel when the left truth is warped to the right.
    """
    check_shape("truth_px", truth_px, (None, None))
    if truth_right_px is not None:
        check_shape("truth_right_px", truth_right_px, truth_px.shape)
    height, width = truth_px.shape
    v, u = np.nonzero(np.isfinite(truth_px))
    disparity = truth_px[v, u]
    u_right = np.rint(u - disparity).astype(np.int64)
    inside = (u_right >= 0) & (u_right < width)
    v, u, u_right, disparity = v[inside], u[inside], u_right[inside], disparity[inside]
    nearest = truth_right_px
    if nearest is None:
        nearest = np.full(truth_px.shape, -np.inf)
        np.maximum.at(nearest, (v, u_right), disparity)
    seen = np.zeros((height, width), dtype=bool)
    seen[v, u] = np.abs(nearest[v, u_right] - disparity) <= MISMATCH_PX
    return seen


def coverage(matches: Matches, shape: tuple[int, int], block_px: int = 32) -> float:
    """Share of the image's square blocks that contain at least one match."""
    blocks = np.zeros([-(-side // block_px) for side in shape], dtype=bool)
    u, v = np.rint(matches.points_px).astype(np.int64).T // block_px
    blocks[v, u] = True
    return float(blocks.mean())
