"""A bar on stderr if that is a terminal, and a message before the one long wait."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click
from tqdm import tqdm

if TYPE_CHECKING:
    from recon.runs.events import Events

tqdm.monitor_interval = 0
"""No thread of its own, which would keep a command from forking."""
MAX_NAMED = 3
"""Running jobs that are named beside the bar."""


@contextmanager
def shown_progress(unit: str, quiet: bool) -> Iterator["Events"]:
    """Events that advance a bar and show the stage beside it."""
    from recon.runs.events import Events

    silent = quiet or not sys.stderr.isatty()
    with tqdm(unit=f" {unit}", disable=silent, file=sys.stderr, leave=False) as bar:
        stages: set[str] = set()

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        def name(stage: str) -> None:
            if stage == "compiling" and stage not in stages and not quiet:
                bar.clear()
                click.echo("recon: compiling kernels (first run only)", err=True)
            stages.add(stage)
            bar.set_postfix_str(stage)

        yield Events(on_progress=show, on_stage=name)


@contextmanager
def shown_jobs(quiet: bool) -> Iterator["ShownJobs"]:
    """A bar for all jobs, with the progress of the running ones."""
    silent = quiet or not sys.stderr.isatty()
    with tqdm(unit=" jobs", disable=silent, file=sys.stderr, leave=False) as bar:
        yield ShownJobs(bar)


class ShownJobs:
    """The jobs of a batch on one line."""

    def __init__(self, bar: "tqdm[Any]") -> None:
        self._bar = bar
        self._running: dict[str, str] = {}

    def progress(self, name: str, done: int, total: int) -> None:
        """Show the progress of one job."""
        self._running[name] = f"{name} {done}/{total}"
        self._bar.set_postfix_str(", ".join(list(self._running.values())[:MAX_NAMED]))

    def end(self, name: str, done: int, total: int) -> None:
        """Count another finished job."""
        self._running.pop(name, None)
        self._bar.total = total
        self._bar.update(done - self._bar.n)
