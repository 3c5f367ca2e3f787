"""Recordings split into jobs of some pairs each, and one job that merges their maps."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from recon.batch.jobfile import NamedJob
from recon.errors import InputError, ReconError
from recon.runs.job import Job
from recon.settings import Settings, given_tree, merged, updated

MERGED = "merged"
"""Name of the merging job."""


def check_chunks(jobs: Sequence[NamedJob]) -> None:
    """Raise `InputError` for jobs that cannot become one map."""
    for one in jobs:
        if one.job.kind != "reconstruct":
            raise InputError(f"{one.name} is {one.job.kind}, but chunks are for reconstruct")
        if one.swept:
            raise InputError(f"{one.name} is one of a sweep, but chunks merge all jobs")


def spread(jobs: Sequence[NamedJob], folder: Path, chunk: int) -> list[NamedJob]:
    """One job for every chunk of pairs of every recording.

    Estimates for a whole recording are computed here, once, and written beside the runs. All jobs
    use the sizes of cells and voxels suggested by the first recording unless they are given. An
    unreadable recording stays one job, which fails with the reason.
    """
    # Late: a batch without chunks reads no recording itself.
    from recon.runs.parts import write_refined

    found: list[NamedJob] = []
    for one in jobs:
        try:
            job = _alike(found, one.job)
            record = folder / f"{one.name}.refined.json"
            num_pairs = write_refined(job.inputs[0], job.settings.sequence, record)
        except (ReconError, OSError):
            found.append(one)
        else:
            found += _parts(replace(one, job=job), record, num_pairs, chunk)
    return found


def _alike(earlier: Sequence[NamedJob], job: Job) -> Job:
    """The job with the cell and voxel sizes of the first recording that was split, or its own."""
    done = [one.job.settings for one in earlier if "part" in one.job.arguments]
    if not done:
        return _with_voxels(job.resolved())
    sizes = {
        "map": {"cell_size": done[0].map.cell_size},
        "surface": {"voxel": done[0].surface.voxel},
    }
    chosen = updated(Settings(), merged(sizes, given_tree(job.settings)))
    return replace(job, settings=chosen).resolved()


def _with_voxels(job: Job) -> Job:
    """The job with a voxel size suggested by its first pair, if a surface needs one."""
    from recon.runs.surfaces import suggested_for

    if not job.settings.wants_surface or job.settings.surface.voxel is not None:
        return job
    voxel = suggested_for(job.inputs[0], job.settings)
    return replace(job, settings=updated(job.settings, {"surface": {"voxel": voxel}}))


def _parts(one: NamedJob, record: Path, num_pairs: int, chunk: int) -> Iterator[NamedJob]:
    for start in range(0, num_pairs, chunk):
        arguments = {
            "chunk": chunk,
            "part": (start, min(start + chunk, num_pairs)),
            "refined": record,
        }
        yield NamedJob(name=f"{one.name}-{start:06d}", job=replace(one.job, arguments=arguments))


def merging(jobs: Sequence[NamedJob], folder: Path) -> NamedJob:
    """The job that merges the runs of all chunks."""
    runs = tuple(folder / one.name for one in jobs)
    return NamedJob(name=MERGED, job=Job(kind="merge", inputs=runs))
