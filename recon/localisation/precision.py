"""Precision of common points, by how well they agree and how many are independent."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.sequences.odometry.tracking import LK_WINDOW_PX, Tracks

Array = NDArray[np.float64]

USUAL = 5.0
"""Number of points that the usual precision of tracks counts as, beside the agreeing ones."""


def shares(tracks: Tracks) -> Array:
    """Weights (N,): tracked windows that overlap share their errors, and count as one."""
    points = tracks.first.points_px
    near = cKDTree(points).query_ball_point(points, LK_WINDOW_PX / 2.0, return_length=True)
    return 1.0 / np.maximum(np.asarray(near, np.float64), 1.0)


def information(residual: Array, derivative: Array, share: Array) -> Array:
    """Information (K, K) of agreeing tracks.

    Their disparities are two to three times as precise as their positions, so that one precision of
    both would be too high for turns and shifts sideways.

    Parameters
    ----------
    residual : (N, 3) array
        Of u, v and disparity, in usual standard deviations.
    derivative : (N, 3, K) array
    share : (N,) array
        Weights of tracks that share their errors.
    """
    variance = (USUAL + share @ residual**2) / (USUAL + share.sum())
    found: Array = np.einsum("n,nij,i,nik->jk", share, derivative, 1.0 / variance, derivative)
    return found
