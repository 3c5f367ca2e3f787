"""Consistency between the clouds of different pairs, without ground truth.

Moving objects and wrong matches are seen by one pair only; other points are confirmed by another.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.geometry import invert, transform
from recon.records import PointCloud, StereoPair

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NUM_SIGMAS = 3.0
"""Maximum difference of the two depths, in standard deviations."""
MAX_OFFSET_PX = 3.0
"""Maximum distance between expected and observed image point: features slide along edges."""
NUM_CANDIDATES = 4
"""Number of nearest points within the offset whose depth is compared."""
SAMPLE_STEP = 8
"""Every n-th point is used for the median distance; all would take longer than the confirmation."""
MIN_DEPTH = 1e-6


class Witness:
    """The points of one pair, compared with those of other pairs."""

    def __init__(self, pair: StereoPair, cloud: PointCloud) -> None:
        """Take a pair with its pose, and its points in the world with their sigma."""
        if pair.T_world_left is None or cloud.sigma is None:
            raise InputError(f"{pair.name} has no pose or its points no sigma: both are needed")
        self.cloud = cloud
        self.sigma = cloud.sigma
        self._rig = pair.rig
        self._T_left_world = invert(pair.T_world_left)
        self.depth = self._points_left(cloud.points)[:, 2]
        """(N,) depth of its own points."""
        self.is_confirmed = np.zeros(len(cloud), np.bool_)
        """(N,) true where another pair agrees."""
        self.counts = True
        """False for a pair that only confirms others."""
        self.sample = np.arange(0, len(cloud), SAMPLE_STEP)
        """(S,) rows of the sampled points."""
        self.distance = np.full(len(self.sample), np.inf)
        """(S,) distance of the samples to the nearest point of another pair, world units."""
        self._seen_at = cKDTree(self._rig.project_left(self._points_left(cloud.points)))
        self._stands_at = cKDTree(cloud.points)

    def hold_against(self, other: "Witness") -> None:
        """Confirm points that `other` saw too: near the same image point, at the same depth."""
        self.is_confirmed |= other._confirms(self)
        distance, _ = other._stands_at.query(self.cloud.points[self.sample])
        self.distance = np.minimum(self.distance, distance)

    def _points_left(self, points_world: Array) -> Array:
        return transform(self._T_left_world, points_world)

    def _confirms(self, other: "Witness") -> Mask:
        confirmed = np.zeros(len(other.cloud), np.bool_)
        points_left = self._points_left(other.cloud.points)
        ahead = np.flatnonzero(points_left[:, 2] > MIN_DEPTH)
        near = self._near(points_left[ahead])
        # A missing neighbour has the last index: infinitely deep, with sigma 0.
        depth, sigma = np.append(self.depth, np.inf)[near], np.append(self.sigma, 0.0)[near]
        apart = np.abs(depth - points_left[ahead, 2:])
        both = np.hypot(sigma, other.sigma[ahead, None])
        confirmed[ahead] = (apart <= NUM_SIGMAS * both).any(axis=1)
        return confirmed

    def _near(self, points_left: Array) -> NDArray[np.int64]:
        """(N, C) own points seen near each given point; missing ones are `len(self.cloud)`."""
        _, near = self._seen_at.query(
            self._rig.project_left(points_left),
            k=NUM_CANDIDATES,
            distance_upper_bound=MAX_OFFSET_PX,
        )
        return np.asarray(near, dtype=np.int64)


class Consistency:
    """Share of points confirmed by neighbouring pairs, counted incrementally."""

    def __init__(self, reach: int = 1, max_depth: float = 30.0) -> None:
        """Compare with `reach` pairs before and after; count points nearer than `max_depth`."""
        self._reach, self._max_depth = reach, max_depth
        self._recent: deque[Witness] = deque()
        self._num_points = self._num_confirmed = 0
        self._median_distances: list[float] = []

    def add(self, pair: StereoPair, cloud: PointCloud, counts: bool = True) -> list[Witness]:
        """Take the next pair with its world points; return the pair that is now settled."""
        new = Witness(pair, cloud)
        new.counts = counts
        for earlier in self._recent:
            earlier.hold_against(new)
            new.hold_against(earlier)
        self._recent.append(new)
        return [self._settle()] if len(self._recent) > self._reach else []

    def finish(self) -> list[Witness]:
        """Settle the remaining pairs after the last one."""
        return [self._settle() for _ in range(len(self._recent))]

    @property
    def share(self) -> float | None:
        """Confirmed share of the near points of all settled pairs; None if there are none."""
        return self._num_confirmed / self._num_points if self._num_points else None

    @property
    def median_distance(self) -> float | None:
        """Median over the pairs of the median distance of near points to other pairs' points."""
        return float(np.median(self._median_distances)) if self._median_distances else None

    def _settle(self) -> Witness:
        settled = self._recent.popleft()
        if not settled.counts:
            return settled
        near = settled.depth < self._max_depth
        self._num_points += int(near.sum())
        self._num_confirmed += int((settled.is_confirmed & near).sum())
        distance = settled.distance[near[settled.sample] & np.isfinite(settled.distance)]
        if distance.size:
            self._median_distances.append(float(np.median(distance)))
        return settled
