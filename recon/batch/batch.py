"""The batch: jobs handed to a scheduler, a run folder for each, a summary of all."""

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
"""The file that every batch leaves first and last, so that its folder is told by it."""
Heard = Callable[[Outcome, int, int], None]
"""Called with every outcome, the number of jobs that ended, and of all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchReport:
    """The outcomes of all jobs of a batch."""

    folder: Path
    jobs: tuple[NamedJob, ...]
    outcomes: tuple[Outcome, ...]
    """In the order of the jobs."""

    @property
    def num_failed(self) -> int:
        """Jobs that failed."""
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
    """Do every job, whatever becomes of the others.

    Parameters
    ----------
    jobs : sequence of NamedJob
    folder : Path
        Gets one run folder per job.
    scheduler : Scheduler
    overwrite, resume : bool
        As of a run; resumed, a job that is done is skipped, and a failed one tried again.
    chunk : int, optional
        Reconstructions are cut into jobs of so many pairs, whose maps become one: the last job,
        which is done where none of the others failed.
    heard : callable
        Told of every job as it ends.

    Returns
    -------
    BatchReport

    Raises
    ------
    InputError
        Where the folder holds anything but a batch, or a batch and neither flag is given.
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
    """Do all jobs, and the one that puts them together."""
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
    if folder.exists() and not (folder.is_dir() and (overwrite or resume)):
        raise InputError(f"{folder} exists; give --overwrite, --resume, or another -o")
    is_filled = folder.exists() and any(folder.iterdir())
    if is_filled and not (folder / SUMMARY).exists():
        raise InputError(f"{folder} is not the folder of a batch; give another -o")
    if is_filled and not resume:
        shutil.rmtree(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / SUMMARY).touch()
