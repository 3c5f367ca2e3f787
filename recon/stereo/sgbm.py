"""OpenCV's semi-global matcher at the features, for comparison and for those who want it."""

import cv2
import numpy as np

from recon.records import Features, Matches
from recon.settings import MatchingSettings

_BLOCK_PX = 3
_SIGMA_PX = 0.25
"""Standard deviation of its right disparities, measured on recorded pairs with truth."""


def match(left: Features, right: Features, settings: MatchingSettings) -> Matches:
    """Disparities of StereoSGBM at the left features, the strongest features first."""
    if not len(left):
        return Matches.none()
    disparity = compute(left, right, settings)
    u, v = left.points_px.astype(np.int64).T
    found = disparity[v, u]
    rows = np.flatnonzero(np.isfinite(found))
    rows = rows[np.argsort(-left.modulus[rows], kind="stable")]
    return Matches(
        points_px=left.points_px[rows],
        disparity_px=found[rows],
        sigma_px=np.full(len(rows), _SIGMA_PX),
        score=left.modulus[rows].astype(np.float64),
        index_left=rows.astype(np.int32),
        index_right=np.full(len(rows), -1, np.int32),
    )


def compute(left: Features, right: Features, settings: MatchingSettings) -> np.ndarray:
    """(H, W) float64 disparity of every left pixel, NaN where there is none."""
    lowest = settings.min_disparity
    wanted = settings.max_disparity - lowest + 1
    matcher = cv2.StereoSGBM.create(
        minDisparity=lowest,
        numDisparities=-(-wanted // 16) * 16,
        blockSize=_BLOCK_PX,
        P1=8 * _BLOCK_PX**2,
        P2=32 * _BLOCK_PX**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=2,
    )
    # Fixed point with four bits below the pixel; below the lowest disparity means none.
    disparity = matcher.compute(left.grey, right.grey) / 16.0
    outside = (disparity < lowest) | (disparity > settings.max_disparity)
    disparity[outside] = np.nan
    return np.asarray(disparity)
