"""Row offsets between two images, and what explains them.

The row offset of a rectified pair is zero. A moving camera leaves offsets that depend on depth, a
turn of one camera about the vertical leaves offsets that grow towards the corners, and lens
distortion left in both images leaves offsets that grow with the disparity towards the corners.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.sequences.contradictions.finding import Finding
from recon.sequences.depth import Image
from recon.sequences.odometry.tracking import Sightings, corners, follow
from recon.sequences.pair_images import grey, levelled

Array = NDArray[np.float64]

MAX_ROW_OFFSET_PX = 0.75
"""Maximum median row offset. Real rigs stay below (KITTI 0.3)."""
INLIER_PX = 1.0
LEVEL_SHARE = 0.85
"""Minimum share of points within a pixel of the fitted rows; sound pairs reach 0.94."""
MIN_MOTION_SHARE, MIN_GAIN = 0.7, 0.1
"""Share of the points that a motion between the images must explain, and how much more than a lens
explains."""
TURNED_SHARE, TURNED_NOISE = 0.5, 2.5
"""Maximum row offset that a turn of one camera may leave, as a share of the offsets and relative to
what a cubic leaves; distortion of one camera leaves 3.6 times the latter."""
SOUND_ROW_OFFSET_PX = 0.35
"""Median row offset of a sound rig."""
MAX_CORNER_PX = 2.5
"""Maximum row offset in the image's corners by a turn; KITTI has 1.6."""
NUM_CORNERS = 300
"""Fewer than for motions, since tracking takes most of the time of a check."""
MIN_TRACKED, MAX_TRACKED_ROWS_PX = 100, 20.0
"""Minimum number of tracked corners, and maximum row offset of one."""
MAX_DISTORTION, MIN_SIGMAS = 0.05, 10.0
"""Displacement of the corners, as a share of their distance from the centre, that a sound pair does
not reach (KITTI and rectified EuRoC 0.04), and its minimum significance."""
NUM_ROUNDS = 15
MIN_SIGMA_PX = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """A turn of one camera about the vertical."""

    disparity_px: float
    """Disparity that it takes from every point."""
    explains_rows: bool
    """True if the rows differ towards the corners, and the turn alone explains it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """A robust linear fit."""

    coefficients: Array
    """(K,)"""
    sigmas: Array
    """(K,) standard deviations of the coefficients."""


def tracked_corners(left: Image, right: Image) -> Sightings:
    """Corners of the left image tracked into the right one, from where they are."""
    one = grey(left)
    points = corners(one, NUM_CORNERS)
    found, is_found = follow(one, levelled(grey(right), one), points)
    offset = points.astype(np.float64) - found
    seen = Sightings(
        points_px=points.astype(np.float64), disparity_px=offset[:, 0], row_offset_px=-offset[:, 1]
    )
    return seen.select(is_found & (np.abs(offset[:, 1]) < MAX_TRACKED_ROWS_PX))


def fitted_turn(seen: Sightings, rig: StereoRig) -> Turn:
    """The turn of one camera about the vertical that the rows show.

    A turn by t changes the disparities by f t, and the rows by f t x y, to first order, with x, y
    in focal lengths from the principal point.
    """
    if len(seen) < MIN_TRACKED:
        return Turn(disparity_px=0.0, explains_rows=False)
    x, y = ((seen.points_px - (rig.cx_left_px, rig.cy_px)) / rig.focal_px).T
    product, rows = (x * y)[:, None], seen.row_offset_px
    turn = float(_fit(product, rows).coefficients[0])
    corner = turn * rig.width * rig.height / (2.0 * rig.focal_px) ** 2
    usual = max(TURNED_NOISE * _residual(_cubic(x, y), rows), SOUND_ROW_OFFSET_PX)
    explained = _residual(product, rows) < min(TURNED_SHARE * np.median(np.abs(rows)), usual)
    return Turn(disparity_px=turn, explains_rows=bool(explained and abs(corner) > MAX_CORNER_PX))


def distortion_finding(seen: Sightings, shape: tuple[int, ...]) -> Finding | None:
    """Radial distortion left in both images alike.

    A point at radius r is displaced by k r^3. As the two cameras see it at different columns, its
    rows differ by k y d (2 x - d), with disparity d and x, y from the centre.
    """
    if len(seen) < MIN_TRACKED:
        return None
    centre = (np.array(shape[1::-1]) - 1) / 2
    radius = float(np.linalg.norm(centre))
    x, y = ((seen.points_px - centre) / radius).T
    d = seen.disparity_px / radius
    design = np.column_stack([_quadratic(x, y), d, d * y, y * d * (2 * x - d)])
    fit = _fit(design, seen.row_offset_px)
    displaced, sigma = abs(fit.coefficients[-1]) / radius, fit.sigmas[-1] / radius
    if displaced < MAX_DISTORTION or displaced < MIN_SIGMAS * sigma:
        return None
    return Finding(
        code="rows-differ",
        text="rows of near points do not correspond towards the corners, as if both images were "
        f"still distorted by about {displaced:.0%} there; undistort them, or rectify them with "
        "their calibration",
    )


def row_finding(seen: Sightings) -> Finding | None:
    """Rows that do not correspond, whatever the reason."""
    middle = float(np.median(seen.row_offset_px))
    typical = float(np.median(np.abs(seen.row_offset_px)))
    if typical <= MAX_ROW_OFFSET_PX:
        return None
    return Finding(
        code="rows-differ",
        text=f"rows of the two images do not correspond: the right one's lie {typical:.1f} px off "
        f"(median {middle:+.1f} px); rectify the images or fix their calibration",
    )


def lag_finding(seen: Sightings) -> Finding | None:
    """Row offsets that depend on depth: a camera moved between the two images."""
    if len(seen) < MIN_TRACKED:
        return None
    is_level = np.abs(seen.row_offset_px - _lens_rows(seen)) < INLIER_PX
    if is_level.mean() > LEVEL_SHARE or np.median(np.abs(seen.row_offset_px)) < MAX_ROW_OFFSET_PX:
        return None
    by_motion = _share_of_motion(seen)
    if by_motion < max(MIN_MOTION_SHARE, is_level.mean() + MIN_GAIN):
        return None
    return Finding(
        code="not-simultaneous",
        text="left and right seem to be taken at different times: a motion between them explains "
        f"{by_motion:.0%} of the common points, corresponding rows {is_level.mean():.0%}",
    )


def _lens_rows(seen: Sightings) -> Array:
    """(N,) row offsets as a function of image position only, fitted robustly."""
    centre, spread = seen.points_px.mean(axis=0), seen.points_px.std(axis=0) + 1e-9
    design = _cubic(*((seen.points_px - centre) / spread).T)
    fitted: Array = design @ _fit(design, seen.row_offset_px, INLIER_PX).coefficients
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


def _residual(design: Array, values: Array) -> float:
    """Median deviation from a robust fit."""
    return float(np.median(np.abs(values - design @ _fit(design, values).coefficients)))


def _quadratic(x: Array, y: Array) -> Array:
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def _cubic(x: Array, y: Array) -> Array:
    return np.column_stack([_quadratic(x, y), x**3, x * x * y, x * y * y, y**3])


def _fit(design: Array, values: Array, scale: float | None = None) -> Fit:
    """Least squares with Cauchy weights, at a scale or twice the standard deviation."""
    weight = np.ones(len(values))
    for _ in range(NUM_ROUNDS):
        weighted = design * weight[:, None]
        coefficients = np.linalg.lstsq(weighted, values * weight, rcond=None)[0]
        error = values - design @ coefficients
        sigma = max(1.4826 * float(np.median(np.abs(error))), MIN_SIGMA_PX)
        weight = 1.0 / np.sqrt(1.0 + (error / (scale or 2.0 * sigma)) ** 2)
    variances = np.diag(np.linalg.pinv(weighted.T @ weighted)) * sigma**2
    return Fit(coefficients=np.asarray(coefficients, np.float64), sigmas=np.sqrt(variances))
