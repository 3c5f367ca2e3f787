"""OpenCV's semi-global matcher, evaluated at the features."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import Features, Matches
from recon.settings import MatchingSettings
from recon.stereo.exposure import with_gain_of
from recon.stereo.kernels.sorting import falling

BLOCK_PX = 3
_SIGMA_PX = 0.25
"""Standard deviation of its correct disparities, measured on recorded pairs with truth."""


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Disparities of StereoSGBM at the left features, the strongest features first."""
    if not len(left):
        return Matches.none()
    disparity = compute(left, right, settings)
    u, v = left.points_px.astype(np.int64).T
    found = disparity[v, u]
    rows = np.flatnonzero(np.isfinite(found))
    rows = rows[falling(left.modulus[rows])]
    return Matches(
        points_px=left.points_px[rows],
        disparity_px=found[rows],
        sigma_px=np.full(len(rows), _SIGMA_PX),
        score=left.modulus[rows].astype(np.float64),
        index_left=rows.astype(np.int32),
        index_right=np.full(len(rows), -1, np.int32),
    )


def compute(left: Features, right: Features, settings: MatchingSettings) -> NDArray[np.float64]:
    """(H, W) float64 disparity of every left pixel, NaN where unknown."""
    width = left.grey.shape[1]
    lowest = max(settings.min_disparity, 1 - width)
    wanted = min(settings.max_disparity, width - 1) - lowest + 1
    if wanted < 1:
        raise InputError(
            f"disparities {settings.min_disparity}..{settings.max_disparity} all lie outside "
            f"the image, whose width is {width}"
        )
    matcher = semi_global(lowest, -(-wanted // 16) * 16)
    # Fixed point with four fractional bits; values below the lowest disparity mean none.
    greys = left.grey, with_gain_of(left.grey, right.grey)
    disparity = matcher.compute(*(_widened(x, lowest, wanted) for x in greys)) / 16.0
    disparity = disparity[:, (disparity.shape[1] - width) // 2 :][:, :width]
    outside = (disparity < lowest) | (disparity > settings.max_disparity)
    disparity[outside] = np.nan
    return np.asarray(disparity)


def semi_global(lowest: int, depth: int, mode: int = cv2.StereoSGBM_MODE_SGBM) -> Any:
    """OpenCV's matcher for `depth` disparities from `lowest` on, a multiple of 16."""
    return cv2.StereoSGBM.create(
        minDisparity=lowest,
        numDisparities=depth,
        blockSize=BLOCK_PX,
        P1=8 * BLOCK_PX**2,
        P2=32 * BLOCK_PX**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=2,
        mode=mode,
    )


def _widened(grey: NDArray[np.uint8], lowest: int, wanted: int) -> NDArray[np.uint8]:
    """The image, with margins if OpenCV would refuse it as narrower than the search range."""
    reach = max(abs(lowest), abs(lowest + wanted)) + wanted + 16
    if reach < grey.shape[1]:
        return grey
    margin = ((0, 0), (reach, reach))
    return np.pad(grey, margin, mode="edge")
