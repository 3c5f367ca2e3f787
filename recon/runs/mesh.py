"""A mesh of a finished run: its pairs are densely matched again at their known poses."""

from pathlib import Path

from recon.runs.arguments import path
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.reading import read_settings
from recon.runs.seen_again import SeenAgain
from recon.runs.surfaces import SurfaceWork
from recon.runs.work import Work
from recon.settings import given_tree, merged


def _mesh(job: Job, work: Work) -> Numbers:
    """Fuse every pixel of the pairs of a run, at the poses of the run."""
    (run,) = job.inputs
    pairs = SeenAgain(run, job.settings, job.arguments.get("recording"))
    surface = SurfaceWork(job.settings, work)
    for number, pair in enumerate(pairs, start=1):
        surface.take(pair)
        work.progress(number, len(pairs))
    return {"num_pairs": len(pairs)} | surface.finish()


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
