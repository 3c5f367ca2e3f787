"""Two images checked against their metadata: rows, sides, simultaneity, disparity range."""

import numpy as np

from recon.camera import StereoRig
from recon.notices import notify
from recon.sequences.contradictions.finding import Finding
from recon.sequences.contradictions.rows import (
    MIN_TRACKED,
    Turn,
    distortion_finding,
    fitted_turn,
    lag_finding,
    row_finding,
    tracked_corners,
)
from recon.sequences.contradictions.survey import Survey, survey
from recon.sequences.depth import Image
from recon.sequences.odometry.tracking import Sightings

MIN_SIGHTINGS = 25
"""Fewer are uninformative."""
MIN_CORNERS, UNRELATED_SHARE = 60, 0.06
"""Minimum number of corners, and the share matched by chance; sound pairs reach a fifth."""
ALIKE_SHARE = 0.3
"""Share of corners that resemble some place in an unrelated image, at most."""
SLACK_PX = 1.5
"""Tolerance for noise beyond both ends of a range."""
SWAPPED_SHARE, OUTSIDE_SHARE = 0.7, 0.1
RANGE = "search-range-too-small"


def check_images(left: Image, right: Image, search: tuple[int, int]) -> frozenset[str]:
    """Notify of contradictions in two images to be matched, and return their codes.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
    search : (min, max)
        Search range of disparities in pixels, both included.
    """
    return _notified(findings(left, right, search=search))


def check_range(left: Image, right: Image, search: tuple[int, int]) -> frozenset[str]:
    """Notify only of disparities outside the search range that no other contradiction explains."""
    # What explains them takes much longer to find than that there are none.
    if _range(survey(left, right).seen, search) is None:
        return frozenset()
    found = findings(left, right, search=search)
    return _notified([finding for finding in found if finding.code == RANGE])


def _notified(found: list[Finding]) -> frozenset[str]:
    for finding in found:
        notify(finding.code, finding.text)
    return frozenset(finding.code for finding in found)


def findings(
    left: Image,
    right: Image,
    *,
    search: tuple[int, int] | None = None,
    rig: StereoRig | None = None,
) -> list[Finding]:
    """Contradictions of a pair; none if too little is seen by both cameras.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8
    search : (min, max), optional
        Search range of disparities in pixels.
    rig : StereoRig, optional
        By default of a usual field of view, with parallel cameras.
    """
    if blank := _blank(left, right):
        return [blank]
    if left.shape == right.shape and np.array_equal(left, right):
        return [Finding(code="same-image", text="left and right are the same image")]
    made, tracked = survey(left, right), tracked_corners(left, right)
    seen = made.seen
    lag = lag_finding(tracked)
    if len(seen) < MIN_SIGHTINGS:
        return [lag] if lag else _unrelated(made, tracked)
    rig = _usual_rig(left) if rig is None else rig
    lowest = rig.disparity_offset_px
    lowest = lowest if search is None else min(lowest, search[0])
    turn = fitted_turn(tracked, rig)
    rows = lag or distortion_finding(tracked, left.shape)
    if rows is None and not turn.explains_rows:
        rows = row_finding(seen)
    turned = None if rows else _turned(seen, turn, lowest, is_calibrated=search is None)
    if turned is not None:
        return [turned]
    sides = _sides(seen, lowest)
    found = [rows, sides]
    if sides is None and rows is None and search is not None:
        found.append(_range(seen, search))
    return [finding for finding in found if finding is not None]


def _blank(left: Image, right: Image) -> Finding | None:
    """Images of a single colour."""
    sides = [
        side for side, image in (("left", left), ("right", right)) if (image == image[:1, :1]).all()
    ]
    if not sides:
        return None
    what = "images are" if len(sides) == 2 else "image is"
    return Finding(
        code="image-blank",
        text=f"the {' and '.join(sides)} {what} blank: all pixels have the same value",
    )


def _usual_rig(image: Image) -> StereoRig:
    """A rig whose images are as wide as their focal length."""
    height, width = image.shape[:2]
    return StereoRig(
        width=width,
        height=height,
        focal_px=float(width),
        cx_left_px=(width - 1) / 2,
        cx_right_px=(width - 1) / 2,
        cy_px=(height - 1) / 2,
        baseline=1.0,
    )


def _unrelated(made: Survey, tracked: Sightings) -> list[Finding]:
    """Images with many corners but nearly no matches, of neither their patches nor their motion."""
    num_seen, num_wanted = len(made.seen), made.num_wanted
    # A repeated pattern matches in many places, which is a match too.
    is_common = num_seen > UNRELATED_SHARE * num_wanted or made.num_alike > ALIKE_SHARE * num_wanted
    # On weak texture noise hides the patches, but not the motion of what is around them.
    if num_wanted < MIN_CORNERS or is_common or len(tracked) >= MIN_TRACKED:
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


def _turned(seen: Sightings, turn: Turn, lowest: float, *, is_calibrated: bool) -> Finding | None:
    """A turn of one camera about the vertical, unless the disparities show swapped sides."""
    behind = float((seen.disparity_px < lowest - SLACK_PX).mean())
    left = float((seen.disparity_px + turn.disparity_px < lowest - SLACK_PX).mean())
    if behind >= SWAPPED_SHARE and left > OUTSIDE_SHARE:
        return None
    if turn.explains_rows:
        what = "rows differ towards the corners as after a turn of one of them"
    elif is_calibrated and behind >= OUTSIDE_SHARE:
        what = (
            f"{behind:.0%} of what both cameras see has a disparity below {lowest:g} px, which is "
            "impossible"
        )
    else:
        return None
    return Finding(
        code="angle-differs",
        text=f"the angle between the cameras is not the calibrated one: {what}; recalibrate",
    )


def _range(seen: Sightings, search: tuple[int, int]) -> Finding | None:
    low, high = search
    if len(seen) < MIN_SIGHTINGS:
        return None
    above = seen.disparity_px > high + SLACK_PX
    below = seen.disparity_px < low - SLACK_PX
    if max(above.mean(), below.mean()) < OUTSIDE_SHARE:
        return None
    found_low, found_high = np.percentile(seen.disparity_px, [2, 98])
    return Finding(
        code=RANGE,
        text=f"{(above | below).mean():.0%} of the points that both cameras see lie outside the "
        f"searched disparities {low} to {high} px: they range from {found_low:.0f} to "
        f"{found_high:.0f} px",
    )
