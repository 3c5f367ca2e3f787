"""Loop closure of a recorded drive: corrects its poses, its points on disk and its map."""

from dataclasses import dataclass, field

import numpy as np

from recon.localisation.keeper import PlaceKeeper
from recon.localisation.loops import close_loops
from recon.mapping.mapper import Mapper, Step
from recon.records import PairSource, StereoPair, Trajectory
from recon.runs.job import Numbers
from recon.runs.outputs import clouds_of, move_cloud
from recon.runs.work import Work
from recon.sequences.estimated_poses import EstimatedPoses
from recon.sequences.frames import DerivedSource
from recon.settings import Settings


def keeps_places(settings: Settings) -> bool:
    """True if places are kept: on request, or for closing loops."""
    return settings.map.places or settings.sequence.poses == "estimated"


def may_close(source: PairSource) -> bool:
    """True if `close_drive` may correct the poses of a drive."""
    return _estimated_in(source) is not None


def close_drive(source: PairSource, mapper: Mapper, places: PlaceKeeper, work: Work) -> Numbers:
    """Correct a drive with estimated poses by its loops; return the metrics."""
    estimated = _estimated_in(source)
    if estimated is None:
        return {}
    before = mapper.trajectory
    with work.stage("localise"):
        closed = close_loops(before.T_world_left, places.atlas(before))
    if closed is None:
        return {"num_loops": 0}
    path = work.run.path / "cloud.ply"
    after = Trajectory(stamps_s=before.stamps_s, T_world_left=closed.poses)
    move_cloud(path, list(before.T_world_left), after)
    mapper.repose(closed.poses, clouds_of(path))
    numbers: Numbers = {
        "num_loops": closed.num_loops,
        "closing_error_before": closed.error_before,
        "closing_error": closed.error_after,
    }
    drift = estimated.drift_percent_of(list(closed.poses))
    if drift is not None:
        before_percent = estimated.drift_percent_of(list(before.T_world_left))
        numbers |= {"drift_percent": drift, "drift_percent_before": before_percent}
    return numbers


@dataclass(slots=True, kw_only=True, eq=False)
class DriveInMemory:
    """A drive with estimated poses, kept without a run folder; its loops are closed at the end."""

    places: PlaceKeeper = field(default_factory=PlaceKeeper)
    steps: list[Step] = field(default_factory=list)
    numbers: set[int] = field(default_factory=set)
    """Of the pairs in the map."""

    def add(self, pair: StereoPair, steps: list[Step], mapper: Mapper) -> None:
        """Take a pair, and the steps that the mapper is done with."""
        number = mapper.num_pairs - 1
        if number not in self.numbers:  # else it only confirms
            self.numbers.add(number)
            self.places.add(pair, number)
        self.steps += steps

    def close(self, mapper: Mapper, last: list[Step]) -> None:
        """Correct poses and map by the loops that the drive has."""
        if not self.numbers:
            return
        before = mapper.trajectory
        closed = close_loops(before.T_world_left, self.places.atlas(before))
        if closed is None:
            return
        moved = closed.poses @ np.linalg.inv(before.T_world_left)
        steps = [*self.steps, *last]
        mapper.repose(
            closed.poses, ((s.cloud.transformed(moved[s.number]), s.number) for s in steps)
        )


def _estimated_in(source: PairSource) -> EstimatedPoses | None:
    """The source of estimated poses inside a source; None if there is none."""
    while isinstance(source, DerivedSource):
        if isinstance(source, EstimatedPoses):
            return source
        source = source.source
    return None
