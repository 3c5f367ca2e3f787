"""The motion of a rig between two pairs, from common points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.camera import StereoRig
from recon.geometry import pose, transform
from recon.sequences.odometry.consensus import consensus
from recon.sequences.odometry.tracking import MIN_SHIFT_PX, Tracks

Array = NDArray[np.float64]

MIN_TRACKS = 12
"""Fewer agreeing tracks may be coincidence."""
RANSAC_PX = 1.0
MAX_SIGMAS = 3.0
"""Maximum residual of an agreeing track, in standard deviations."""
TRACK_SIGMA_PX = 0.2
"""Standard deviation of a tracked corner in u, v and disparity; fits of a drive leave 0.18."""
NUM_ROUNDS = 8
DAMPING = 1e-12
"""Relative to the trace: collinear points leave the rotation about their line undetermined."""
MIN_DEPTH = 1e-9
"""Minimum depth; points that a motion puts at the camera get it, and agree with nothing."""
SMALL_CHANGE = 1e-6
"""Radians and world units: far below the precision of tracks."""

MEDIAN_DISTANCE = 1.54
"""Median norm of three independent standard normal errors."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Linearised:
    """Whitened residuals of N tracks and their derivatives at a motion and a disparity shift."""

    residual: Array
    """(N, 3) of u, v and disparity in the second pair, in standard deviations."""
    by_motion: Array
    """(N, 3, 6) by a small rotation and translation of the second left frame."""
    by_shift: Array
    """(N, 3, 2) by an offset of the first and the second disparity."""

    @property
    def distances(self) -> Array:
        """(N,) residuals of the tracks, in standard deviations."""
        distances: Array = np.linalg.norm(self.residual, axis=1)
        return distances

    @property
    def weights(self) -> Array:
        """(N,) Cauchy weights."""
        return 1.0 / (1.0 + self.distances**2)

    @property
    def spread(self) -> float:
        """Robust standard deviation of the whitened residuals; at least 1."""
        return max(1.0, float(np.median(self.distances)) / MEDIAN_DISTANCE)

    def normal_equations(self) -> tuple[Array, Array]:
        """Information (6, 6) of the motion, and the gradient (6,) of the cost by it."""
        weighted = self.by_motion * self.weights[:, None, None]
        information = np.einsum("nij,nik->jk", weighted, self.by_motion)
        return information, np.einsum("nij,ni->j", weighted, self.residual)

    @property
    def costs(self) -> Array:
        """(N,) Cauchy's robust cost."""
        costs: Array = np.log1p(self.distances**2)
        return costs


def estimate_motion(tracks: Tracks, rig: StereoRig) -> Array | None:
    """`T_second_first` (4, 4) of the left camera, None if too few tracks agree.

    A robust start by perspective-n-point, then a joint refinement of u, v and disparity, weighted
    by the uncertainty of the first depth.
    """
    agreeing = agreeing_tracks(tracks, rig)
    if agreeing is None:
        return None
    T_second_first, rows = agreeing
    return refine_motion(T_second_first, tracks.select(rows), rig)


def agreeing_tracks(tracks: Tracks, rig: StereoRig) -> tuple[Array, NDArray[np.bool_]] | None:
    """A first `T_second_first` (4, 4), and the mask (N,) of the tracks that agree on it."""
    near = are_near(tracks, rig)
    if np.count_nonzero(near) < MIN_TRACKS:
        return None
    candidates = tracks.select(near)
    start = _ransac(candidates, rig)
    if start is None:
        return None
    T_second_first, inliers = start
    # A sample of few points is noisy: evaluate all tracks again with the fit of many.
    refined = refine_motion(T_second_first, candidates.select(inliers), rig)
    if refined is None:
        return None
    rows = np.zeros(len(tracks), np.bool_)
    rows[near] = linearise(refined, candidates, rig).distances < MAX_SIGMAS
    return refined, rows


def _ransac(tracks: Tracks, rig: StereoRig) -> tuple[Array, NDArray[np.int32]] | None:
    """A motion (4, 4) and the indices of the tracks that agree on it."""
    return consensus(
        rig.triangulate(tracks.first.points_px, tracks.first.disparity_px),
        tracks.second.points_px,
        rig.K_left,
        reach_px=RANSAC_PX, num_draws=200, confidence=0.9999, least=MIN_TRACKS,
    )  # fmt: skip


def are_near(tracks: Tracks, rig: StereoRig) -> NDArray[np.bool_]:
    """(N,) mask of the tracks whose disparities determine a depth."""
    least = MIN_SHIFT_PX + rig.disparity_offset_px
    near: NDArray[np.bool_] = (
        np.minimum(tracks.first.disparity_px, tracks.second.disparity_px) > least
    )
    return near


def refine_motion(T_second_first: Array, tracks: Tracks, rig: StereoRig) -> Array | None:
    """Gauss-Newton with Cauchy weights, starting from an approximate motion.

    None if the tracks do not determine a motion, as with coincident points or points at the camera.
    """
    try:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            refined = _refined(T_second_first, tracks, rig)
    except (np.linalg.LinAlgError, ValueError):
        return None
    return refined if np.isfinite(refined).all() else None


def _refined(T_second_first: Array, tracks: Tracks, rig: StereoRig) -> Array:
    for _ in range(NUM_ROUNDS):
        at = linearise(T_second_first, tracks, rig)
        normal, gradient = at.normal_equations()
        normal += DAMPING * np.trace(normal) * np.eye(6)
        change = np.asarray(-np.linalg.solve(normal, gradient), dtype=np.float64)
        T_second_first = motion_changed(T_second_first, change)
        if np.abs(change).max() < SMALL_CHANGE:
            break
    return T_second_first


def motion_changed(T_second_first: Array, change: Array) -> Array:
    """The motion after a small rotation `change[:3]` and step `change[3:]` of the second frame."""
    return pose(Rotation.from_rotvec(change[:3]).as_matrix(), change[3:]) @ T_second_first


def linearise(T_second_first: Array, tracks: Tracks, rig: StereoRig) -> Linearised:
    """Whitened residuals and derivatives at a motion."""
    first = rig.triangulate(tracks.first.points_px, tracks.first.disparity_px)
    second = transform(T_second_first, first)
    second[np.abs(second[:, 2]) < MIN_DEPTH, 2] = MIN_DEPTH
    predicted = np.column_stack([rig.project_left(second), rig.disparity(second[:, 2])])
    seen = np.column_stack([tracks.second.points_px, tracks.second.disparity_px])
    by_point = _projection_derivative(second, rig)
    by_motion = by_point @ np.concatenate([-_cross(second), _eyes(len(tracks))], axis=2)
    # d(first point) / d(first disparity) = -point / shift.
    shift = tracks.first.disparity_px - rig.disparity_offset_px
    by_first = by_point @ (-(first / shift[:, None]) @ T_second_first[:3, :3].T)[:, :, None]
    by_second = np.broadcast_to([[0.0], [0.0], [-1.0]], by_first.shape)
    whiten = _whitening(by_first)
    return Linearised(
        residual=np.einsum("nij,nj->ni", whiten, predicted - seen),
        by_motion=whiten @ by_motion,
        by_shift=whiten @ np.concatenate([by_first, by_second], axis=2),
    )


def _projection_derivative(points: Array, rig: StereoRig) -> Array:
    """(N, 3, 3) derivatives of u, v, disparity by the point."""
    x, y, z = points.T
    zero = np.zeros_like(z)
    rows = [[1 / z, zero, -x / z**2], [zero, 1 / z, -y / z**2], [zero, zero, -rig.baseline / z**2]]
    return rig.focal_px * np.moveaxis(np.array(rows), 2, 0)


def _whitening(by_first: Array) -> Array:
    """(N, 3, 3) inverse square roots of the residuals' covariance.

    The first disparity is as uncertain as the compared values: S = s^2 (I + j j^T), whose root has
    a closed form that is stable even for tracks near the camera.
    """
    j = by_first[:, :, 0]
    length_sq = np.maximum((j * j).sum(axis=1), np.finfo(np.float64).tiny)
    share = (1.0 - 1.0 / np.sqrt(1.0 + length_sq)) / length_sq
    inverse: Array = np.eye(3) - (share[:, None] * j)[:, :, None] * j[:, None, :]
    return inverse / TRACK_SIGMA_PX


def _cross(points: Array) -> Array:
    x, y, z = points.T
    zero = np.zeros_like(z)
    return np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), 2, 0)


def _eyes(number: int) -> Array:
    return np.broadcast_to(np.eye(3), (number, 3, 3))
