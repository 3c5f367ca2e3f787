"""A true disparity compared with the images and the matches that it is to judge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.notices import notify
from recon.records import Matches
from recon.sequences.depth import Image
from recon.sequences.truth import DisparityTruth

Array = NDArray[np.float64]

MIN_JUDGED = 50
"""Minimum number of matches with known truth."""
AGREEING_SHARE, CHANCE_SHARE = 0.5, 0.1
"""Share of matches that agree with sound truth, and at most by chance with an unrelated one."""
AGREEING_PX = 1.0
MIN_SIGMAS = 4.0
"""Minimum lead of one reading over another, in standard deviations of chance."""
FACTORS = (-1.0, *(sign * 2.0**power for power in range(1, 9) for sign in (-1.0, 1.0)))
"""Common scale errors of either sign; their inverses are tried too."""


def check_truth(left: Image, matches: Matches, truth: DisparityTruth) -> None:
    """Report a truth that the matches contradict as a whole.

    Raises
    ------
    InputError
        If the truth differs in size from the left image.
    """
    check_truth_size(left, truth)
    known = _known(matches, truth.disparity_px)
    share = known.agreeing(known.as_left)
    if len(known.found_px) < MIN_JUDGED:
        return
    if known.is_of_right:
        share_right = known.agreeing(known.as_right)
        notify(
            "truth-disagrees",
            f"the truth is the right image's: {share_right:.0%} of the matches agree with it at "
            f"their positions there, {share:.0%} at those in the left image",
        )
    elif share < AGREEING_SHARE:
        reading = _reading(known)
        if reading or share < CHANCE_SHARE:
            word = reading or "is it the left image's, of these two?"
            notify("truth-disagrees", f"{share:.0%} of the matches agree with the truth; {word}")


def check_truth_size(left: Image, truth: DisparityTruth) -> None:
    """Raise `InputError` if the truth differs in size from the left image."""
    height, width = truth.disparity_px.shape
    if left.shape[:2] != (height, width):
        raise InputError(
            f"truth is {width} x {height} pixels, but the left image has "
            f"{left.shape[1]} x {left.shape[0]}"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Known:
    """Matches with known truth, and what the truth says by several readings, NaN where unknown."""

    found_px: Array
    """(N,) disparities of the matches."""
    as_left: Array
    """(N,) truth at their points in the left image."""
    as_right: Array
    """(N,) truth at their points in the right image."""
    upside_down: Array
    """(N,) truth of the left image with the rows in the opposite order."""

    def agreeing(self, true: Array) -> float:
        """Share of the matches that agree with a truth (N,)."""
        return float(self._agree(true).mean()) if len(true) else 0.0

    @property
    def is_of_right(self) -> bool:
        """True if significantly more matches agree with the truth as that of the right image."""
        left, right = self._agree(self.as_left), self._agree(self.as_right)
        only_left = np.count_nonzero(left & ~right)
        only_right = np.count_nonzero(right & ~left)
        lead = only_right - only_left
        return bool(
            right.mean() >= AGREEING_SHARE and lead > MIN_SIGMAS * np.sqrt(only_left + only_right)
        )

    def _agree(self, true: Array) -> NDArray[np.bool_]:
        agree: NDArray[np.bool_] = np.abs(self.found_px - true) <= AGREEING_PX
        return agree


def _known(matches: Matches, true: Array) -> _Known:
    height, width = true.shape
    u, v = np.rint(matches.points_px).astype(np.int64).T
    u_right = np.rint(matches.points_px[:, 0] - matches.disparity_px).astype(np.int64)
    inside = (u_right >= 0) & (u_right < width)
    as_right = np.where(inside, true[v, np.clip(u_right, 0, width - 1)], np.nan)
    as_left = true[v, u]
    known = np.isfinite(as_left) | np.isfinite(as_right)
    return _Known(
        found_px=matches.disparity_px[known],
        as_left=as_left[known],
        as_right=as_right[known],
        upside_down=true[height - 1 - v, u][known],
    )


def _reading(known: _Known) -> str:
    """The reading with which most matches agree, in words; empty if there is none."""
    factors = [*FACTORS, *(1.0 / factor for factor in FACTORS)]
    shares = [known.agreeing(factor * known.as_left) for factor in factors]
    best = int(np.argmax(shares))
    if shares[best] >= AGREEING_SHARE:
        return f"{shares[best]:.0%} do with the truth times {factors[best]:g}: is its scale right?"
    share = known.agreeing(known.upside_down)
    return f"{share:.0%} do with its rows upside down" if share >= AGREEING_SHARE else ""
