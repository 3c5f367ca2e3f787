"""Resection: the pose of an image from landmarks that it shows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from recon.geometry import Array, invert
from recon.localisation.landmarks import MIN_COSINE, NUM_NEIGHBOURS, SIGMA_PX, Landmarks
from recon.localisation.registration import inverse, moved
from recon.localisation.sights import Sight, matched
from recon.sequences.odometry.consensus import consensus

START_PX, MIN_START = 2.0, 6
"""Greatest error, and least number, of the landmarks of one image that agree on a pose."""
REACHES_PX = (6.0, 4.0, 3.0)
"""Distance of features from landmarks that are the same, in each round."""
NUM_NEAREST = 4
"""Features near a landmark of which the most alike is taken."""
MIN_LIKENESS = 0.72
"""Least cosine of the descriptors of the same landmark in two images."""
MAX_SIGMAS_SQ = 9.0
MEDIAN_SQ = 1.39
"""Median squared length of two independent standard normal errors."""
NUM_STEPS, SMALL_CHANGE = 10, 1e-8
MIN_DEPTH = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Start:
    """An approximate pose by the landmarks of one image."""

    T_world_camera: Array
    num_agreeing: int
    """Landmarks that agree on it."""
    depth: float
    """Median depth of the landmarks."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Resection:
    """The pose of an image among landmarks."""

    T_world_camera: Array
    covariance: Array
    """(6, 6), in the order of `PoseEstimate`."""
    num_agreeing: int
    """Features that are where landmarks are seen."""
    num_near: int
    """Features near which landmarks that look alike are seen."""
    depth: float
    """Median depth of the landmarks."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Links:
    """Features of an image, each with the mean of the landmarks that it may show."""

    points_px: Array
    """(N, 2)"""
    points: Array
    """(N, 3) world."""
    covariance: Array
    """(N, 3, 3)"""

    def __len__(self) -> int:
        return len(self.points)


def resected(query: Sight, known: Sequence[Landmarks], start: Array) -> Resection | None:
    """The pose of an image by all landmarks in view; None if they do not determine it.

    Parameters
    ----------
    query : Sight
    known : sequence of Landmarks
    start : (4, 4) array
        An approximate pose.
    """
    found = None
    for reach_px in REACHES_PX:
        links = _linked(query, _in_view(known, start), start, reach_px)
        found = _fitted(query, links, start) if len(links) >= MIN_START else None
        if found is None:
            return None
        start = found.T_world_camera
    return found


def _in_view(known: Sequence[Landmarks], T_world_camera: Array) -> list[Landmarks]:
    """The landmarks of the images nearest to a pose that look the same way."""
    alike = [one for one in known if one.sight.ahead @ T_world_camera[:3, 2] > MIN_COSINE]
    alike.sort(key=lambda one: float(np.linalg.norm(one.sight.eye - T_world_camera[:3, 3])))
    return alike[:NUM_NEIGHBOURS]


def started(query: Sight, start: Landmarks) -> Start | None:
    """The pose on which landmarks of one image agree; None if too few do."""
    own, there = matched(query.rooted, start.rooted)
    if len(own) < MIN_START:
        return None
    found = consensus(
        start.points[there], query.points_px[own], query.K,
        reach_px=START_PX, num_draws=300, confidence=0.999, least=MIN_START,
    )  # fmt: skip
    if found is None:
        return None
    T_camera_world, inliers = found
    return Start(
        T_world_camera=invert(T_camera_world), num_agreeing=len(inliers), depth=start.depth
    )


def _linked(
    query: Sight, known: Sequence[Landmarks], T_world_camera: Array, reach_px: float
) -> _Links:
    """The features near which landmarks that look alike are seen from a pose."""
    total, moment = np.zeros((len(query), 3, 3)), np.zeros((len(query), 3))
    rooted, tree = query.rooted, cKDTree(query.points_px)
    for one in known:
        depth, seen_px = _projected(query, T_world_camera, one.points)
        off_px, near = tree.query(seen_px, NUM_NEAREST, distance_upper_bound=reach_px)
        near = np.minimum(near, len(query) - 1)  # where there is none, off by infinity
        likeness = np.einsum("ld,lkd->lk", one.rooted, rooted[near])
        likeness = np.where(np.isfinite(off_px), likeness, 0.0)
        best = likeness.argmax(axis=1)[:, None]
        feature = np.take_along_axis(near, best, axis=1)[:, 0]
        is_same = (likeness.max(axis=1) > MIN_LIKENESS) & (depth > 0.0)
        information = inverse(one.covariance[is_same])
        np.add.at(total, feature[is_same], information)
        moved_by = np.einsum("nij,nj->ni", information, one.points[is_same])
        np.add.at(moment, feature[is_same], moved_by)
    rows = np.flatnonzero(total[:, 0, 0] > 0.0)
    covariance = inverse(total[rows])
    return _Links(
        points_px=query.points_px[rows],
        points=np.einsum("nij,nj->ni", covariance, moment[rows]),
        covariance=covariance,
    )


def _projected(query: Sight, T_world_camera: Array, points: Array) -> tuple[Array, Array]:
    """Depths (N,) of points and where (N, 2) an image from a pose shows them."""
    local = (points - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]
    depth = np.where(np.abs(local[:, 2]) < MIN_DEPTH, MIN_DEPTH, local[:, 2])
    return depth, query.focal_px * local[:, :2] / depth[:, None] + query.K[:2, 2]


def _fitted(query: Sight, links: _Links, T_world_camera: Array) -> Resection | None:
    """The pose by Gauss-Newton with Cauchy weights; None if it is not determined."""
    try:
        for _ in range(NUM_STEPS):
            residual, by_pose = _linearised(query, links, T_world_camera)
            off_sq = (residual**2).sum(axis=1)
            weight = 1.0 / (1.0 + off_sq / 4.0)
            information = np.einsum("nik,nil,n->kl", by_pose, by_pose, weight)
            gradient = np.einsum("nik,ni,n->k", by_pose, residual, weight)
            change = -np.linalg.solve(information, gradient)
            T_world_camera = moved(T_world_camera, change)
            if np.abs(change).max() < SMALL_CHANGE:
                break
    except (np.linalg.LinAlgError, ValueError):
        return None
    if not np.isfinite(T_world_camera).all():
        return None
    depth, _ = _projected(query, T_world_camera, links.points)
    spread_sq = max(1.0, float(np.median(off_sq)) / MEDIAN_SQ)
    return Resection(
        T_world_camera=T_world_camera,
        covariance=spread_sq * inverse(information),
        num_agreeing=int(((off_sq < MAX_SIGMAS_SQ) & (depth > 0.0)).sum()),
        num_near=len(links),
        depth=float(np.median(depth)),
    )


def _linearised(query: Sight, links: _Links, T_world_camera: Array) -> tuple[Array, Array]:
    """Whitened residuals (N, 2) and their derivatives (N, 2, 6) by the pose."""
    turn, offset = T_world_camera[:3, :3], links.points - T_world_camera[:3, 3]
    depth, seen_px = _projected(query, T_world_camera, links.points)
    by_local = np.zeros((len(links), 2, 3))
    by_local[:, 0, 0] = by_local[:, 1, 1] = query.focal_px / depth
    by_local[:, :, 2] = -(seen_px - query.K[:2, 2]) / depth[:, None]
    by_point = by_local @ turn.T
    covariance = by_point @ links.covariance @ by_point.transpose(0, 2, 1) + SIGMA_PX**2 * np.eye(2)
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    # A turn w of the camera moves points relative to it by offset x w.
    by_turn = np.cross(by_point, offset[:, None])
    by_pose = np.concatenate([by_turn, -by_point], axis=2)
    return np.einsum("nij,nj->ni", whiten, seen_px - links.points_px), whiten @ by_pose
