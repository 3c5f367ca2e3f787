"""Precision of common points, by how well they agree and how many are independent."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.sequences.odometry.tracking import LK_WINDOW_PX, Tracks

Array = NDArray[np.float64]

USUAL = 1.0
"""Number of points that the usual precision of tracks counts as, beside the agreeing ones."""
ALONE = 1e-6
"""Share of its information that remains of a track that nothing confirms."""


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
    weight = 1.0 / _variance(residual, share)
    found: Array = np.einsum("n,nij,i,nik->jk", share, derivative, weight, derivative)
    return found


def _variance(residual: Array, share: Array) -> Array:
    """Variances (3,) of u, v and disparity."""
    found: Array = (USUAL + share @ residual**2) / (USUAL + share.sum())
    return found


def supported(residual: Array, derivative: Array, share: Array) -> Array:
    """Derivatives (N, 3, K), weighted by how far each track is confirmed by the others.

    A track that alone is near, or alone far, is followed wherever it errs, and leaves no residual.
    Its leverage is the share of its own in what is predicted of it, 0 to 1; tracks that share their
    errors have the leverage of one. Where all have the same, each keeps its information.
    """
    known = information(residual, derivative, share)
    own = np.einsum("nij,jk,nik->ni", derivative, np.linalg.pinv(known), derivative)
    own /= _variance(residual, share)
    usual = min(len(known) / (3.0 * share.sum()), 1.0 - ALONE)
    confirmed = np.maximum(1.0 - own, ALONE) / (1.0 - usual)
    found: Array = derivative * np.sqrt(confirmed)[..., None]
    return found
