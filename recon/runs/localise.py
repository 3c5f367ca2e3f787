"""Poses of pairs in the map of a run."""

import itertools
import math
from pathlib import Path
from typing import Any

from recon.errors import InputError
from recon.localisation.atlas import Atlas
from recon.localisation.keeper import PlaceKeeper
from recon.localisation.recall import KnownWorld
from recon.records import FitFailure, PoseEstimate, StereoPair, Trajectory
from recon.runs.arguments import path
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.reading import read_reconstruction, read_settings
from recon.runs.seen_again import SeenAgain
from recon.runs.work import Work
from recon.sequences.open import open_sequence
from recon.settings import SequenceSettings, given_tree

PLACES = "places.npz"
MAX_SHOWN = 200
"""Maximum number of pairs, evenly chosen, that show landmarks and the colours of objects."""


def _localise(job: Job, work: Work) -> Numbers:
    """Find the poses of pairs in the map of a run."""
    run, taken = _inputs(job)
    made = read_reconstruction(run)
    with work.stage("places"):
        atlas, pairs_shown = seen(run, job)
    known = KnownWorld.of(made.voxels, atlas, job.settings, tuple(made.objects))
    with work.stage("places"):
        known = known.painted(shown(run, job) if pairs_shown is None else pairs_shown)
    pairs = open_sequence(taken, SequenceSettings(poses="none"))
    poses = []
    for number, pair in enumerate(pairs, start=1):
        with work.stage("localise"):
            poses.append(as_entry(pair, known.recall(pair)))
        work.progress(number, len(pairs))
    return {"poses": poses, "num_found": sum(one["T_world_left"] is not None for one in poses)}


def as_entry(pair: StereoPair, found: PoseEstimate | FitFailure) -> dict[str, Any]:
    """The result for one pair; nulls with the reason if it cannot be localised."""
    keys = ("T_world_left", "sigma", "sigma_deg", "probability", "reason")
    if isinstance(found, FitFailure):
        return {"name": pair.name} | dict.fromkeys(keys) | {"reason": found.reason}
    values = (
        found.T_world_left.tolist(), found.sigma, found.sigma_deg, found.probability, None,
    )  # fmt: skip
    return {"name": pair.name} | dict(zip(keys, values, strict=True))


def seen(run: Path, job: Job) -> tuple[Atlas, list[StereoPair] | None]:
    """The places stored by a run, else computed again, with pairs read meanwhile that show it."""
    if (run / PLACES).is_file():
        return Atlas.load(run / PLACES), None
    keeper, again = PlaceKeeper(), _again(run, job)
    step, found = _step(again), []
    for number, pair in enumerate(again):
        keeper.add(pair, number)
        if number % step == 0:
            found.append(pair)
    poses = again.poses
    return keeper.atlas(Trajectory(stamps_s=poses[:, 0, 0], T_world_left=poses)), found


def _again(run: Path, job: Job) -> SeenAgain:
    return SeenAgain(run, read_settings(run), job.arguments.get("recording"))


def shown(run: Path, job: Job) -> list[StereoPair]:
    """Pairs that show what a run has seen; none if only its places are left."""
    try:
        again = _again(run, job)
    except InputError:
        if job.arguments.get("recording"):
            raise
        return []
    return list(itertools.islice(again, 0, None, _step(again)))


def _step(again: SeenAgain) -> int:
    """Every how many pairs one shows what the run has seen."""
    return max(math.ceil(len(again) / MAX_SHOWN), 1)


def _inputs(job: Job) -> tuple[Path, Path]:
    run, taken = job.inputs
    if not (run / "map.npz").is_file() or not (run / "trajectory.txt").is_file():
        raise InputError(f"{run} is not a run: a map.npz and a trajectory.txt are needed")
    return run, taken


def _base(job: Job) -> Tree:
    """Settings for matching and mapping as in the run."""
    run, _ = _inputs(job)
    kept = ("matching", "features", "triangulation", "map")
    return {stage: given_tree(read_settings(run))[stage] for stage in kept}


LOCALISE = Kind(
    run=_localise,
    num_inputs=2,
    base=_base,
    takes={"recording": path},
    stages=("places", "localise"),
)
