"""The batch: jobs run by a scheduler, a run folder for each, a summary of all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recon.batch.chunks import check_chunks, merging, spread
from recon.batch.folder import opened
from recon.batch.jobfile import NamedJob
from recon.batch.schedulers import Scheduler, bound
from recon.batch.worker import Outcome, do
from recon.runfolder import named

Heard = Callable[[Outcome, int, int], None]
"""Called with every outcome, the number of jobs ended, and the number of all jobs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchReport:
    """The outcomes of all jobs of a batch."""

    folder: Path
    jobs: tuple[NamedJob, ...]
    outcomes: tuple[Outcome, ...]
    """In the order of the jobs."""

    @property
    def num_failed(self) -> int:
        """Number of failed jobs."""
        return sum(outcome.state == "failed" for outcome in self.outcomes)

    def as_json(self) -> dict[str, Any]:
        """The document of `recon batch --json` and of `summary.json`."""
        return {"jobs": [outcome.as_json() for outcome in self.outcomes]}


def run_batch(
    jobs: Sequence[NamedJob],
    folder: Path,
    scheduler: Scheduler,
    *,
    overwrite: bool = False,
    resume: bool = False,
    chunk: int | None = None,
    heard: Heard = lambda outcome, done, total: None,
) -> BatchReport:
    """Run every job, regardless of failures of others.

    Parameters
    ----------
    jobs : sequence of NamedJob
    folder : Path
        Folder for the run folders.
    scheduler : Scheduler
    overwrite, resume : bool
        As for a run; when resumed, finished jobs are skipped, and failed ones tried again. A batch
        that is replaced is kept as `.NAME.before` until no job of the new one fails.
    chunk : int, optional
        Pairs per job: reconstructions are split into jobs of this size, whose maps are merged by a
        last job if no other failed.
    heard : callable
        Called for every job as it ends.

    Returns
    -------
    BatchReport

    Raises
    ------
    InputError
        If the folder contains anything but a batch, a batch and neither flag is given, or an input
        that would be replaced.
    """
    if chunk is not None:
        check_chunks(jobs)
    folder = named(folder)
    inputs = [path for one in jobs for path in one.job.inputs]
    with opened(folder, inputs, overwrite=overwrite, resume=resume) as earlier:
        report = _all_done(jobs, folder, scheduler, chunk, heard)
        if not report.num_failed:
            earlier.remove()
    return report


def _all_done(
    jobs: Sequence[NamedJob],
    folder: Path,
    scheduler: Scheduler,
    chunk: int | None,
    heard: Heard,
) -> BatchReport:
    """Run all jobs, and the one that merges them."""
    if chunk is not None:
        jobs = spread(jobs, folder, chunk)
    report = _done(jobs, folder, scheduler, heard)
    if chunk is None or report.num_failed:
        return report
    merged = _done([merging(jobs, folder)], folder, scheduler, heard)
    return BatchReport(
        folder=folder, jobs=report.jobs + merged.jobs, outcomes=report.outcomes + merged.outcomes
    )


def _done(
    jobs: Sequence[NamedJob], folder: Path, scheduler: Scheduler, heard: Heard
) -> BatchReport:
    calls = [(job.name, bound(do, job, folder / job.name)) for job in jobs]
    ended: dict[str, Outcome] = {}
    for outcome in scheduler.outcomes(calls):
        ended[outcome.name] = outcome
        heard(outcome, len(ended), len(jobs))
    return BatchReport(
        folder=folder, jobs=tuple(jobs), outcomes=tuple(ended[job.name] for job in jobs)
    )
