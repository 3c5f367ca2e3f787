"""Execution of jobs: the single entry point for the command line, batches and web pages."""

from contextlib import closing
from pathlib import Path

from recon.errors import check_path, check_type
from recon.notices import Notice, collected_notices
from recon.runfolder import RunFolder, check_flags
from recon.runs.artist import Artist
from recon.runs.events import Events
from recon.runs.job import KINDS, Job, Numbers
from recon.runs.outputs import as_document
from recon.runs.report import Report, read_report
from recon.runs.work import Work
from recon.sequences.calibration.refinement import shared_estimates
from recon.sequences.recent import recent_images
from recon.stopwatch import Stopwatch


def execute(
    job: Job,
    folder: str | Path | None = None,
    events: Events | None = None,
    *,
    overwrite: bool = False,
    resume: bool = False,
    num_workers: int = 1,
    artist: Artist | None = None,
) -> Report:
    """Execute a job.

    Parameters
    ----------
    job : Job
        Missing settings are filled in from its kind and inputs.
    folder : path, optional
        The run folder to write; by default `runs/NAME` for kinds that always write one.
    events : Events, optional
        Callbacks for progress and cancellation.
    overwrite : bool
        Replace an existing run.
    resume : bool
        Resume an interrupted run; a finished one is left untouched, and its report read.
    num_workers : int
        Number of parallel processes, if the kind of job can use them.
    artist : Artist, optional
        Draws the figures; by default this process.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        If an input is unusable, the folder contains another run, or the flags contradict each other
        or have no folder to act on.
    """
    check_type("job", job, Job)
    events = Events() if events is None else events
    check_type("events", events, Events)
    if folder is not None:
        check_path(folder)
    stopwatch = Stopwatch(events.on_stage)
    with (
        collected_notices() as notices,
        stopwatch.counting_compilation(),
        shared_estimates(),
        recent_images(),
    ):
        kind = KINDS.load(job.kind)
        path = Path(folder) if folder else kind.folder(job.located())
        # Before the job is resolved, as that may take long.
        check_flags(path, overwrite=overwrite, resume=resume)
        job = job.resolved()
        if path is None:
            work = Work(events=events, stopwatch=stopwatch, folder=None, num_workers=num_workers)
            return _reported(job, kind.run(job, work), notices)
        run = RunFolder.prepare(path, job.plan(), overwrite=overwrite, resume=resume)
        if not run.is_finished:
            with run.opened(), closing(artist or Artist()) as drawing:
                work = Work(
                    events=events, stopwatch=stopwatch, folder=run, num_workers=num_workers,
                    artist=drawing,
                )  # fmt: skip
                numbers = kind.run(job, work)
                run.seconds = dict.fromkeys(kind.stages, 0.0) | stopwatch.seconds
                report = _reported(job, {"seconds": run.seconds} | numbers, notices)
                run.write_json("metrics.json", report.as_json())
    return read_report(job.kind, run.path)


def _reported(job: Job, numbers: Numbers, notices: list[Notice]) -> Report:
    return Report(kind=job.kind, numbers=as_document(numbers), warnings=tuple(notices))
