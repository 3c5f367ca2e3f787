"""The batch: jobs run by a scheduler, a run folder for each, a summary of all."""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recon.batch.chunks import check_chunks, merging, spread
from recon.batch.jobfile import NamedJob
from recon.batch.schedulers import Scheduler, bound
from recon.batch.worker import Outcome, do
from recon.errors import InputError
from recon.locks import locked

SUMMARY = "summary.json"
"""The file that every batch writes first and last, which identifies its folder."""
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
        As for a run; when resumed, finished jobs are skipped, and failed ones tried again.
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
        If the folder contains anything but a batch, or a batch and neither flag is given.
    """
    if chunk is not None:
        check_chunks(jobs)
    folder.parent.mkdir(parents=True, exist_ok=True)
    busy = f"{folder} is being written by another batch; wait for it, or give another -o"
    with locked(folder.with_name(f".{folder.name}.lock"), busy):
        _prepare(folder, overwrite=overwrite, resume=resume)
        return _all_done(jobs, folder, scheduler, chunk, heard)


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


def _prepare(folder: Path, *, overwrite: bool, resume: bool) -> None:
    if overwrite and resume:
        raise InputError("overwrite and resume exclude each other: give one of them")
    if folder.exists() and not (folder.is_dir() and (overwrite or resume)):
        raise InputError(f"{folder} exists; give --overwrite, --resume, or another -o")
    is_filled = folder.exists() and any(folder.iterdir())
    if is_filled and not (folder / SUMMARY).exists():
        raise InputError(f"{folder} is not the folder of a batch; give another -o")
    if is_filled and not resume:
        shutil.rmtree(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / SUMMARY).touch()
