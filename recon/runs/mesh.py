"""A mesh of a run whose poses are known: its recording seen again, every pixel of it."""

from dataclasses import replace
from pathlib import Path

from recon.errors import InputError
from recon.records import Trajectory
from recon.runfolder import read_manifest
from recon.runs.arguments import path
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.reading import read_settings
from recon.runs.surfaces import SurfaceWork
from recon.runs.work import Work
from recon.sequences.open import open_sequence
from recon.settings import given_tree, merged, updated


def _mesh(job: Job, work: Work) -> Numbers:
    """Fuse every pixel of the pairs of a run, which stand where the run found them."""
    (run,) = job.inputs
    recording = _recording(job)
    path = run / "trajectory.txt"
    trajectory = Trajectory.from_tum(path.read_text("utf-8"), str(path))
    poses = trajectory.T_world_left
    # The run's poses are taken, however it came by them.
    unposed = updated(job.settings, {"sequence": {"poses": "given"}}).sequence
    source = open_sequence(recording, unposed)
    surface = SurfaceWork(job.settings, work)
    for number, pair in enumerate(source):
        if number >= len(poses):
            raise InputError(f"{run} has {len(poses)} poses, but its recording has more pairs")
        surface.take(replace(pair, T_world_left=poses[number]))
        work.progress(number + 1, len(poses))
    return {"num_pairs": len(poses)} | surface.finish()


def _recording(job: Job) -> Path:
    """The recording that the run was made of."""
    (run,) = job.inputs
    named = job.arguments.get("recording")
    if named is not None:
        return Path(named)
    manifest = read_manifest(run)
    if manifest["command"] != "reconstruct":
        raise InputError(
            f"{run} is a run of {manifest['command']}, but one of reconstruct is needed; "
            "recon explore --mesh leaves a mesh itself"
        )
    sources = manifest.get("sources") or [""]
    path = Path(sources[0])
    if not sources[0] or not path.exists():
        raise InputError(f"the recording of {run} is not at {str(path)!r}: give --recording PATH")
    return path


def _base(job: Job) -> Tree:
    (run,) = job.inputs
    return merged(given_tree(read_settings(run)), {"surface": {"mesh": True}})


MESH = Kind(
    run=_mesh,
    base=_base,
    takes={"recording": path},
    folder=lambda job: Path("runs") / f"{job.inputs[0].resolve().name}_mesh",
    stages=("dense", "surface", "figures", "write"),
)
"""`recon mesh`."""
