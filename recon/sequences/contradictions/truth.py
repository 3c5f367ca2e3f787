"""A true disparity compared with the images and the matches that it is to judge."""

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
FACTORS = (-1.0, *(sign * 2.0**power for power in range(1, 9) for sign in (-1.0, 1.0)))
"""Common scale errors of either sign; their inverses are tried too."""


def check_truth(left: Image, matches: Matches, truth: DisparityTruth) -> None:
    """Report a truth that the matches contradict as a whole.

    Raises
    ------
    InputError
        If the truth differs in size from the left image.
    """
    height, width = truth.disparity_px.shape
    if left.shape[:2] != (height, width):
        raise InputError(
            f"truth is {width} x {height} pixels, but the left image has "
            f"{left.shape[1]} x {left.shape[0]}"
        )
    u, v = np.rint(matches.points_px).astype(np.int64).T
    true, found = truth.disparity_px[v, u], matches.disparity_px
    is_known = np.isfinite(true)
    share = _agreeing(found[is_known], true[is_known])
    if np.count_nonzero(is_known) < MIN_JUDGED or share >= AGREEING_SHARE:
        return
    reading = _reading(found[is_known], true[is_known])
    if reading or share < CHANCE_SHARE:
        word = reading or "is it the left image's, of these two?"
        notify("truth-disagrees", f"{share:.0%} of the matches agree with the truth; {word}")


def _agreeing(found: Array, true: Array) -> float:
    return float((np.abs(found - true) <= AGREEING_PX).mean()) if len(found) else 0.0


def _reading(found: Array, true: Array) -> str:
    """The scale at which most matches agree, in words; empty if there is none."""
    factors = [*FACTORS, *(1.0 / factor for factor in FACTORS)]
    shares = [_agreeing(found, factor * true) for factor in factors]
    best = int(np.argmax(shares))
    if shares[best] < AGREEING_SHARE:
        return ""
    return f"{shares[best]:.0%} do with the truth times {factors[best]:g}: is its scale right?"
