"""What has come of the pairs of a recording so far: as large as the map and the trajectory."""

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.mapping.consistency import Consistency, Witness
from recon.mapping.pair import insert, points_of
from recon.records import Matches, PointCloud, StereoPair
from recon.runs.contents import Trajectory
from recon.settings import Settings
from recon.voxelmap.occupancy import new_map


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Seen:
    """One pair and what it gave."""

    number: int
    """0, 1, ..."""
    pair: StereoPair
    matches: Matches
    cloud: PointCloud
    """World."""


class Tally:
    """Puts pairs into a map, and counts.

    Pairs with poses are held against the one before and the one after. Where only confirmed
    points are wanted, a pair goes into the map when the next one has come.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.voxel_map = new_map(settings.map)
        self.consistency = Consistency(max_depth=settings.sequence.max_confirmed_depth)
        self.clearest: Seen | None = None
        self.num_points = 0
        self.num_voxels = 0
        self.stereo_s = 0.0
        self.map_s = 0.0
        self._stamps_s: list[float] = []
        self._poses: list[NDArray[np.float64]] = []
        self._waiting: deque[Seen] = deque()

    @property
    def num_pairs(self) -> int:
        """Pairs read so far."""
        return len(self._poses)

    @property
    def trajectory(self) -> Trajectory:
        """One row a pair read, in order."""
        return Trajectory(
            stamps_s=np.array(self._stamps_s),
            T_world_left=np.array(self._poses).reshape(-1, 4, 4),
        )

    @property
    def metrics(self) -> dict[str, Any]:
        """The numbers of `metrics.json` that need no truth."""
        return {
            "num_pairs": self.num_pairs,
            "num_points": self.num_points,
            "num_voxels": self.num_voxels,
            "confirmed_share": self.consistency.share if self.num_pairs > 1 else None,
            "confirmed_distance_median": self.consistency.median_distance,
        }

    def take(self, pair: StereoPair) -> Iterator[Seen]:
        """Take the next pair; give the pairs whose points are now in the map."""
        began = time.perf_counter()
        matches, cloud = points_of(pair, self.settings)
        self.stereo_s += time.perf_counter() - began
        seen = Seen(number=self.num_pairs, pair=pair, matches=matches, cloud=cloud)
        self._stamps_s.append(pair.stamp_s)
        self._poses.append(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
        if self.clearest is None or len(matches) > len(self.clearest.matches):
            self.clearest = seen
        if pair.T_world_left is None:
            yield self._insert(seen, cloud)
            return
        self._waiting.append(seen)
        yield from self._settle(self.consistency.add(pair, cloud))

    def finish(self) -> Iterator[Seen]:
        """Give the pairs that still waited for a next one."""
        yield from self._settle(self.consistency.finish())

    def _settle(self, witnesses: list[Witness]) -> Iterator[Seen]:
        for witness in witnesses:
            seen = self._waiting.popleft()
            cloud = seen.cloud
            if self.settings.sequence.only_confirmed and self.num_pairs > 1:
                cloud = cloud.select(witness.is_confirmed)
            yield self._insert(seen, cloud)

    def _insert(self, seen: Seen, cloud: PointCloud) -> Seen:
        began = time.perf_counter()
        insert(cloud, seen.pair, self.settings, self.voxel_map, seen.number)
        self.map_s += time.perf_counter() - began
        self.num_points += len(cloud)
        return replace(seen, cloud=cloud)
