"""Consistency between the clouds of different pairs, without ground truth.

Moving objects and wrong matches are seen by one pair only; other points are confirmed by another.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.errors import InputError
from recon.geometry import invert, transform
from recon.mapping.seendepths import SeenDepths
from recon.records import PointCloud, StereoPair

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NUM_SAMPLES = 1000
"""Approximate number of a pair's points used for the median distance, evenly spread; all would take
longer than the confirmation."""
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
        points_left = self._points_left(cloud.points)
        self.depth = points_left[:, 2]
        """(N,) depth of its own points."""
        self.is_confirmed = np.zeros(len(cloud), np.bool_)
        """(N,) true where another pair agrees."""
        self.counts = True
        """False for a pair that only confirms others."""
        self.sample = np.arange(0, len(cloud), max(1, len(cloud) // NUM_SAMPLES))
        """(S,) rows of the sampled points."""
        self.distance = np.full(len(self.sample), np.inf)
        """(S,) distance of the samples to the nearest point of another pair, world units."""
        at_px = self._rig.project_left(points_left)
        size = self._rig.width, self._rig.height
        self._seen = SeenDepths(at_px, self.depth, self.sigma, size)
        # Few points are looked up: a tree that is built fast suits better than a balanced one.
        self._stands_at = cKDTree(cloud.points, balanced_tree=False, compact_nodes=False)

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
        at_px = self._rig.project_left(points_left[ahead])
        confirmed[ahead] = self._seen.agree(at_px, points_left[ahead, 2], other.sigma[ahead])
        return confirmed


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
