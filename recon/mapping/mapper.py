"""The loop from pairs to the map, the same for recordings and explorations."""

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import check_type
from recon.geometry import LEVEL_CAMERA
from recon.mapping.consistency import Consistency, Witness
from recon.mapping.pair import PairResult, count_points, insert, match_points
from recon.mapping.reached import Reached
from recon.mapping.views import CellCounts, count_cells, with_views
from recon.recognition.recognition import recognise
from recon.records import (
    Matches,
    PointCloud,
    Recognition,
    Reconstruction,
    StereoPair,
    Trajectory,
    Voxels,
)
from recon.settings import Settings
from recon.stopwatch import Stopwatch
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import new_map, occupied


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """One pair with its matches and points."""

    number: int
    """0, 1, ..."""
    pair: StereoPair
    matches: Matches
    cloud: PointCloud
    """World; the points inserted into the map."""
    doubtful: PointCloud
    """World; the uncertain points inserted into its coarser cells."""

    def __repr__(self) -> str:
        return (
            f"Step({self.number}: {self.pair.name}, {len(self.matches)} matches, "
            f"{len(self.cloud)} points)"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """The pairs of one part of a recording that is processed in parts."""

    first: int = 0
    """Number of the first pair of the part, in the whole recording."""
    counts: Callable[[int], bool] = lambda number: True
    """False for the number of a pair that only confirms others."""

    def __contains__(self, number: int) -> bool:
        return self.counts(number)


class Mapper:
    """Inserts pairs into a map, one at a time, and keeps the statistics.

    Parameters
    ----------
    settings : Settings, optional
    stopwatch : Stopwatch, optional
        Measures the time of the stages `stereo`, `map` and `recognise`.
    compares : bool
        Compare pairs that have poses with the previous and the next one (`confirmed_share`). If
        only confirmed points are wanted, a pair is inserted when the next one has arrived.
    counts_views : bool
        Remember which cells each pair hit, so that `reconstruction` can count views of objects.
    part : Part, optional
        If a recording is processed in parts: the pairs, and those that count.
    """

    def __init__(
        self,
        settings: Settings | None = None,
        *,
        stopwatch: Stopwatch | None = None,
        compares: bool = True,
        counts_views: bool = True,
        part: Part | None = None,
    ) -> None:
        self.settings = Settings() if settings is None else settings
        check_type("settings", self.settings, Settings)
        self.voxel_map = new_map(self.settings.map)
        self.consistency = Consistency(max_depth=self.settings.sequence.max_confirmed_depth)
        self.clearest: Step | None = None
        """The step with the most matches."""
        self.num_points = 0
        self.reached = Reached()
        self._stopwatch = stopwatch or Stopwatch()
        self._compares = compares
        self._part = part or Part()
        self._num_taken = 0
        self._seen: list[CellCounts] | None = [] if counts_views else None
        self._stamps_s: list[float] = []
        self._poses: list[NDArray[np.float64]] = []
        self._waiting: deque[Step] = deque()

    def __repr__(self) -> str:
        return (
            f"Mapper({self.num_pairs} pairs, {self.num_points} points, "
            f"{self.voxel_map.num_cells} cells)"
        )

    def release(self) -> VoxelMap:
        """Return the map so far and start an empty one, so that a recording can be endless."""
        released, self.voxel_map = self.voxel_map, new_map(self.settings.map)
        return released

    @property
    def num_pairs(self) -> int:
        """Pairs taken so far."""
        return len(self._poses)

    @property
    def trajectory(self) -> Trajectory:
        """One pose per pair taken, in order."""
        return Trajectory(
            stamps_s=np.array(self._stamps_s), T_world_left=np.array(self._poses).reshape(-1, 4, 4)
        )

    @property
    def metrics(self) -> dict[str, Any]:
        """The numbers of `metrics.json` that need no truth."""
        return {
            "num_pairs": self.num_pairs,
            "num_points": self.num_points,
            "confirmed_share": self.consistency.share if self.num_pairs > 1 else None,
            "confirmed_distance_median": self.consistency.median_distance,
            **self.reached.metrics,
        }

    def process(self, pair: StereoPair, result: PairResult | None = None) -> list[Step]:
        """Process the next pair and return the steps whose points are now in the map.

        Parameters
        ----------
        result : PairResult, optional
            Its matches and points, if already computed.
        """
        check_type("pair", pair, StereoPair)
        if result is None:
            with self._stopwatch.stage("stereo"):
                result = match_points(pair, self.settings)
        number = self._part.first + self._num_taken
        self._num_taken += 1
        step = Step(
            number=number,
            pair=pair,
            matches=result.matches,
            cloud=result.cloud,
            doubtful=result.doubtful,
        )
        if number in self._part:
            self._count(step, result)
        with self._stopwatch.stage("map"):
            return [one for one in self._settle(step) if one.number in self._part]

    def _count(self, step: Step, result: PairResult) -> None:
        pose = step.pair.T_world_left
        self.reached.see(result)
        self._stamps_s.append(step.pair.stamp_s)
        self._poses.append(LEVEL_CAMERA if pose is None else pose)
        if self.clearest is None or len(step.matches) > len(self.clearest.matches):
            self.clearest = step

    def finish(self) -> list[Step]:
        """Insert the steps that still waited for a next pair, and return them."""
        with self._stopwatch.stage("map"):
            settled = self._confirmed(self.consistency.finish())
            return [one for one in settled if one.number in self._part]

    def repose(self, poses: NDArray[np.float64], clouds: Iterable[tuple[PointCloud, int]]) -> None:
        """Rebuild the map after the poses were corrected.

        Parameters
        ----------
        poses : (N, 4, 4) float64
            `T_world_left` of all pairs.
        clouds : iterable of (PointCloud, int)
            Precise points at their corrected positions, with the number of their pair.
        """
        self._poses = list(poses)
        self.voxel_map = new_map(self.settings.map)
        with self._stopwatch.stage("map"):
            for cloud, number in clouds:
                count_points(cloud, poses[number, :3, 3], self.settings, self.voxel_map, number)

    def voxels(self) -> Voxels:
        """The occupied cells, by the rules of the settings."""
        return occupied(self.voxel_map, self.settings.map)

    def recognise(self, voxels: Voxels, seen: Iterable[CellCounts] | None = None) -> Recognition:
        """Find and name the objects of the map.

        Parameters
        ----------
        voxels : Voxels
            The occupied cells.
        seen : iterable of CellCounts, optional
            Cells that the pairs hit; by default those remembered.
        """
        with self._stopwatch.stage("recognise"):
            views = self.trajectory.T_world_left
            found = recognise(voxels, self.settings.recognition, views)
            return with_views(found, voxels, (self._seen or []) if seen is None else seen)

    def reconstruction(self) -> Reconstruction[VoxelMap]:
        """The result of all pairs so far."""
        voxels = self.voxels()
        return Reconstruction(
            map=self.voxel_map,
            voxels=voxels,
            objects=self.recognise(voxels).objects,
            trajectory=self.trajectory,
        )

    def _settle(self, step: Step) -> list[Step]:
        """Insert the points that need not wait, or need not wait any longer."""
        if step.pair.T_world_left is None or not self._compares:
            return [self._insert(step)]
        witnesses = self.consistency.add(step.pair, step.cloud, step.number in self._part)
        if not self.settings.sequence.only_confirmed:
            return [self._insert(step)]
        self._waiting.append(step)
        return self._confirmed(witnesses)

    def _confirmed(self, witnesses: list[Witness]) -> list[Step]:
        """Insert the confirmed points of waiting pairs; for a single pair, all points."""
        if not self._waiting:
            return []
        steps = [(self._waiting.popleft(), witness) for witness in witnesses]
        if self._num_taken == 1:
            return [self._insert(step) for step, _ in steps]
        chosen = ((step, step.cloud.select(seen.is_confirmed)) for step, seen in steps)
        nothing = slice(0, 0)
        return [
            self._insert(replace(step, cloud=cloud, doubtful=step.doubtful.select(nothing)))
            for step, cloud in chosen
        ]

    def _insert(self, step: Step) -> Step:
        if step.number not in self._part:
            return step
        self.reached.num_mapped += insert(
            step.cloud, step.doubtful, step.pair, self.settings, self.voxel_map, step.number
        )
        self.num_points += len(step.cloud)
        if self._seen is not None:
            self._seen.append(count_cells(step.cloud, step.number, self.settings.map.cell_size))
        return step
