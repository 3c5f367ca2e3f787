"""The path from the options of a command to an executed and reported job."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.options import build_settings
from recon.cli.output import print_document, start_logging
from recon.cli.progress import shown_progress

if TYPE_CHECKING:
    from recon.runs.artist import Artist
    from recon.runs.report import Report


def do_job(
    kind: str,
    inputs: tuple[Path, ...],
    given: dict[str, Any],
    *,
    say: Callable[["Report"], None],
    draws: bool = False,
    unit: str = "pairs",
    **arguments: Any,
) -> None:
    """Make a job from a command's options, execute it, and print the result.

    Parameters
    ----------
    given : dict
        All options of the command; those of settings and of the run folder are looked up by name.
    say : callable
        Prints the human-readable report.
    draws : bool
        The job draws figures, in other processes if possible.
    unit : str
        Unit of the progress.
    arguments
        Further arguments of the job; None means not given.
    """
    start_logging(given)
    artist = _artist_apart() if draws else None  # first: its process loads while this one does
    from recon.libraries import load_unused_late

    load_unused_late()
    from recon.runs.execute import execute
    from recon.runs.job import Job

    job = Job(
        kind=kind,
        inputs=inputs,
        arguments={name: value for name, value in arguments.items() if value is not None},
        settings=build_settings(given),
        seed=given.get("seed", 0),
    )
    with shown_progress(unit, given["quiet"]) as events:
        report = execute(
            job, given.get("output"), events,
            overwrite=given.get("overwrite", False), resume=given.get("resume", False),
            num_workers=given.get("num_workers") or 1, artist=artist,
        )  # fmt: skip
    if given["as_json"]:
        print_document(given, report.as_json(), ())
    elif not given["quiet"]:
        say(report)
    if report.is_interrupted:
        raise click.Abort


def _artist_apart() -> "Artist | None":
    """Other processes if this one is the command's own and may use more than one thread."""
    from recon.threads import num_threads

    if not click.get_current_context().find_root().obj or num_threads() == 1:
        return None
    from recon.runs.artist import OtherProcesses, start_drawing

    return OtherProcesses(start_drawing())


def counted(number: int, noun: str) -> str:
    """ "1 pair", "2 pairs"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
