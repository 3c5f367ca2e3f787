"""Errors of dense disparities, and calibration of their sigmas."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import check_shape
from recon.records import DisparityMap
from recon.stereo.evaluation import MISMATCH_PX, seen_by_both

Array = NDArray[np.floating]


@dataclass(frozen=True, slots=True, kw_only=True)
class DenseEvaluation:
    """Percent of the pixels with known truth, and errors in pixels; NaN = nothing to count."""

    covered: float
    right: float
    """Share within a pixel of the truth, of all pixels."""
    right_nonocc: float
    """The same for pixels also visible to the right camera."""
    wrong: float
    median_px: float
    """Median error of all covered pixels."""
    within_1_sigma: float
    within_2_sigma: float

    def as_metrics(self) -> dict[str, float]:
        """The metrics by name."""
        return asdict(self)


def judge(
    found: DisparityMap,
    truth_px: Array,
    quantisation_px: float = 0.0,
    right_px: Array | None = None,
) -> DenseEvaluation:
    """Compare every pixel with the true disparity of the left image.

    Parameters
    ----------
    truth_px : (H, W)
        NaN = unknown.
    quantisation_px : float
        Quantisation step of the truth; if it is a whole pixel, disparities are rounded like the
        truth before they are classified as right or wrong.
    right_px : (H, W), optional
        True disparity of the right image's pixels, for occlusion.
    """
    check_shape("truth_px", truth_px, found.disparity_px.shape)
    known = np.isfinite(truth_px)
    covered = known & found.valid_mask
    whole = np.rint(found.disparity_px) if quantisation_px >= 1 else found.disparity_px
    right = covered & (np.abs(whole - truth_px) <= MISMATCH_PX)
    seen = seen_by_both(truth_px, right_px) & known
    error = np.abs(found.disparity_px - truth_px)[covered]
    sigma = found.sigma_px[covered]
    return DenseEvaluation(
        covered=_percent(covered[known]),
        right=_percent(right[known]),
        right_nonocc=_percent(right[seen]),
        wrong=_percent((covered & ~right)[known]),
        median_px=float(np.median(error)) if error.size else float("nan"),
        within_1_sigma=_percent(error <= sigma),
        within_2_sigma=_percent(error <= 2 * sigma),
    )


def _percent(mask: NDArray[np.bool_]) -> float:
    return 100 * float(mask.mean()) if mask.size else float("nan")
