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
    use the cell size suggested by the first recording unless one is given. An unreadable recording
    stays one job, which fails with the reason.
    """
    # Late: a batch without chunks reads no recording itself.
    from recon.runs.parts import write_refined

    found: list[NamedJob] = []
    for one in jobs:
        try:
            job = _with_cells_of(found, one.job).resolved()
            record = folder / f"{one.name}.refined.json"
            num_pairs = write_refined(job.inputs[0], job.settings.sequence, record)
        except (ReconError, OSError):
            found.append(one)
        else:
            found += _parts(replace(one, job=job), record, num_pairs, chunk)
    return found


def _with_cells_of(earlier: Sequence[NamedJob], job: Job) -> Job:
    sizes = [one.job.settings.map.cell_size for one in earlier if "part" in one.job.arguments]
    if not sizes:
        return job
    suggested = {"map": {"cell_size": sizes[0]}}
    return replace(job, settings=updated(Settings(), merged(suggested, given_tree(job.settings))))


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
