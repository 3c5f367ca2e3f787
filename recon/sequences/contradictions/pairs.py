"""Two images checked against their metadata: rows, sides, simultaneity, disparity range."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.notices import notify
from recon.sequences.contradictions.survey import Survey, survey
from recon.sequences.depth import Image
from recon.sequences.odometry.tracking import Sightings

Array = NDArray[np.float64]

MIN_SIGHTINGS = 25
"""Fewer are uninformative."""
MIN_CORNERS, UNRELATED_SHARE = 60, 0.06
"""Minimum number of corners, and the share matched by chance; sound pairs reach a fifth."""
ALIKE_SHARE = 0.3
"""Share of corners that resemble some place in an unrelated image, at most."""
MAX_ROW_OFFSET_PX = 0.75
"""Maximum median row offset. Real rigs stay below (KITTI 0.3)."""
INLIER_PX = 1.0
LEVEL_SHARE = 0.85
"""Minimum share of points within a pixel of the fitted rows; sound pairs reach 0.94."""
MIN_GAIN = 0.1
"""Additional share of points that a motion between the images must explain."""
SLACK_PX = 1.5
"""Tolerance for noise beyond both ends of a range."""
SWAPPED_SHARE, OUTSIDE_SHARE = 0.7, 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One contradiction in a pair of images."""

    code: str
    text: str


def check_images(
    left: Image, right: Image, search: tuple[int, int], *, only: str | None = None
) -> None:
    """Notify of contradictions in two images to be matched.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
    search : (min, max)
        Search range of disparities in pixels, both included.
    only : str, optional
        The only code to report; by default all.
    """
    for finding in findings(left, right, search=search):
        if only in (None, finding.code):
            notify(finding.code, finding.text)


def findings(
    left: Image,
    right: Image,
    *,
    search: tuple[int, int] | None = None,
    nearest_px: float = 0.0,
) -> list[Finding]:
    """Contradictions of a pair; none if too little is seen by both cameras.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
    search : (min, max), optional
        Search range of disparities in pixels.
    nearest_px : float
        Disparity of a point at infinity, the lower bound.
    """
    if left.shape == right.shape and np.array_equal(left, right):
        return [Finding(code="same-image", text="left and right are the same image")]
    made = survey(left, right)
    seen = made.seen
    if len(seen) < MIN_SIGHTINGS:
        return _unrelated(made)
    lowest = nearest_px if search is None else min(nearest_px, search[0])
    found = [_moment(seen) or _rows(seen), _sides(seen, lowest)]
    if found[1] is None:
        found.append(_behind(seen, lowest) if search is None else _range(seen, search))
    return [finding for finding in found if finding is not None]


def _unrelated(made: Survey) -> list[Finding]:
    """Images with many corners but nearly no matches."""
    num_seen, num_wanted = len(made.seen), made.num_wanted
    # A repeated pattern matches in many places, which is a match too.
    is_common = num_seen > UNRELATED_SHARE * num_wanted or made.num_alike > ALIKE_SHARE * num_wanted
    if num_wanted < MIN_CORNERS or is_common:
        return []
    return [
        Finding(
            code="images-unrelated",
            text=f"left and right show almost nothing in common: {num_seen} of {num_wanted} "
            "corners are found again; is one of them rotated, or of another place?",
        )
    ]


def _sides(seen: Sightings, lowest: float) -> Finding | None:
    behind = seen.disparity_px < lowest - SLACK_PX
    if behind.mean() < SWAPPED_SHARE:
        return None
    low, high = np.percentile(seen.disparity_px, [5, 95])
    return Finding(
        code="left-right-swapped",
        text=f"left and right seem to be swapped: {behind.mean():.0%} of the common points have "
        f"a disparity below {lowest:g} px ({low:.0f} to {high:.0f} px)",
    )


def _behind(seen: Sightings, lowest: float) -> Finding | None:
    """Many points behind infinity, but not all: the angle between the cameras is wrong."""
    behind = seen.disparity_px < lowest - SLACK_PX
    if behind.mean() < OUTSIDE_SHARE:
        return None
    return Finding(
        code="behind-infinity",
        text=f"{behind.mean():.0%} of what both cameras see has a disparity below {lowest:g} px, "
        "which is impossible: the angle between the cameras is not the calibrated one, or left and "
        "right were taken at different times",
    )


def _rows(seen: Sightings) -> Finding | None:
    middle = float(np.median(seen.row_offset_px))
    typical = float(np.median(np.abs(seen.row_offset_px)))
    if typical <= MAX_ROW_OFFSET_PX:
        return None
    return Finding(
        code="rows-differ",
        text=f"rows of the two images do not correspond: the right one's lie {typical:.1f} px off "
        f"(median {middle:+.1f} px); rectify the images or fix their calibration",
    )


def _moment(seen: Sightings) -> Finding | None:
    """Row offsets that depend on depth: a camera moved between the two images."""
    is_level = np.abs(seen.row_offset_px - _lens_rows(seen)) < INLIER_PX
    if is_level.mean() > LEVEL_SHARE or np.median(np.abs(seen.row_offset_px)) < MAX_ROW_OFFSET_PX:
        return None
    by_motion = _share_of_motion(seen)
    if by_motion - is_level.mean() < MIN_GAIN:
        return None
    return Finding(
        code="not-simultaneous",
        text="left and right seem to be taken at different times: a motion between them explains "
        f"{by_motion:.0%} of the common points, corresponding rows {is_level.mean():.0%}",
    )


def _lens_rows(seen: Sightings) -> Array:
    """(N,) row offsets as a function of image position only, fitted robustly."""
    centre, spread = seen.points_px.mean(axis=0), seen.points_px.std(axis=0) + 1e-9
    x, y = ((seen.points_px - centre) / spread).T
    design = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    fitted = np.full(len(seen), np.median(seen.row_offset_px))
    for _ in range(10):
        error = (seen.row_offset_px - fitted) / INLIER_PX
        weight = 1.0 / np.sqrt(1.0 + error**2)
        fitted = (
            design
            @ np.linalg.lstsq(design * weight[:, None], seen.row_offset_px * weight, rcond=None)[0]
        )
    return fitted


def _share_of_motion(seen: Sightings) -> float:
    """Share of points explained by one general epipolar geometry."""
    try:
        _, inliers = cv2.findFundamentalMat(
            seen.points_px, seen.right_points_px, cv2.FM_RANSAC, INLIER_PX, 0.999
        )
    except cv2.error:
        return 0.0
    return 0.0 if inliers is None else float(inliers.mean())


def _range(seen: Sightings, search: tuple[int, int]) -> Finding | None:
    low, high = search
    above = seen.disparity_px > high + SLACK_PX
    below = seen.disparity_px < low - SLACK_PX
    if max(above.mean(), below.mean()) < OUTSIDE_SHARE:
        return None
    found_low, found_high = np.percentile(seen.disparity_px, [2, 98])
    return Finding(
        code="search-range-too-small",
        text=f"{(above | below).mean():.0%} of the points that both cameras see lie outside the "
        f"searched disparities {low} to {high} px: they range from {found_low:.0f} to "
        f"{found_high:.0f} px",
    )
