"""Consensus: the camera pose on which most known points agree (PnP inside RANSAC)."""

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array, pose


def consensus(
    points: Array,
    points_px: Array,
    K: Array,
    *,
    reach_px: float,
    num_draws: int,
    confidence: float,
    least: int,
) -> tuple[Array, NDArray[np.int32]] | None:
    """The pose of a camera, and the points that agree on it; None if too few do.

    Parameters
    ----------
    points : (N, 3) array
    points_px : (N, 2) array
        Their places in the image.
    K : (3, 3) array
    reach_px : float
        Greatest error of a point that agrees.
    num_draws : int
        Greatest number of samples.
    confidence : float
        Probability at which sampling ends early.
    least : int
        Least number of points that agree.

    Returns
    -------
    T_camera_points : (4, 4) array
    agreeing : (M,) array of int32
        Their indices.
    """
    try:
        found, turn, step, inliers = cv2.solvePnPRansac(
            points, points_px, K, None,
            iterationsCount=num_draws, reprojectionError=reach_px, confidence=confidence,
            flags=cv2.SOLVEPNP_SQPNP,
        )  # fmt: skip
    except cv2.error:  # points that nearly coincide
        return None
    if not found or inliers is None or len(inliers) < least:
        return None
    return pose(cv2.Rodrigues(turn)[0], step.ravel()), inliers.ravel()
