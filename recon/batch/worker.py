"""One job run by a worker, and its outcome."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from recon.batch.jobfile import NamedJob
from recon.errors import InputError, ReconError
from recon.manifest import is_finished, read_manifest

State = Literal["done", "failed", "skipped"]
Progress = Callable[[str, int, int], None]
"""Called with the name of a job, the amount done, and its upper bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """The outcome of one job."""

    name: str
    state: State
    error: str | None = None
    """One line if it failed."""
    seconds: float = 0.0
    numbers: Mapping[str, Any] = field(default_factory=dict)
    """Its `metrics.json`."""
    names: tuple[tuple[str, str], ...] = ()
    """The true name of each object and its assigned one, if truth is known."""

    def as_json(self) -> dict[str, Any]:
        """The outcome as an entry of `summary.json`."""
        own = {"name": self.name, "state": self.state, "error": self.error}
        numbers = {name: value for name, value in self.numbers.items() if name != "seconds"}
        return own | {"seconds": round(self.seconds, 3)} | numbers


def ignore_progress(name: str, done: int, total: int) -> None:
    """Ignore the progress."""


_listener: list[Progress] = [ignore_progress]
"""The progress callback of this process."""


def report_progress_to(progress: Progress | None) -> None:
    """Set the progress callback for all jobs of this process."""
    _listener[:] = [progress or ignore_progress]


def do(named: NamedJob, folder: Path) -> Outcome:
    """Run one job in its own run folder, or resume it if its worker was lost.

    No exception except a keyboard interrupt escapes: a failed job never stops the others. It is
    reported before it begins, and does not begin if its batch was interrupted meanwhile.
    """
    _listener[-1](named.name, 0, 1)
    began = time.perf_counter()
    was_done = is_finished(folder)
    try:
        numbers = _execute(named, folder)
        names = _names(named, folder)
    except ReconError as error:
        fault = " ".join(str(error).split())
    except OSError as error:
        fault = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    # A plug-in or an unforeseen error: the batch continues.
    except Exception as error:
        fault = f"{type(error).__name__}: {' '.join(str(error).split())}"
    else:
        seconds = time.perf_counter() - began
        state: State = "skipped" if was_done else "done"
        return Outcome(name=named.name, state=state, seconds=seconds, numbers=numbers, names=names)
    seconds = time.perf_counter() - began
    return Outcome(name=named.name, state="failed", error=fault, seconds=seconds)


def is_begun(run: Path) -> bool:
    """True for a run folder that can be resumed."""
    try:
        read_manifest(run)
    except InputError:
        return False
    return True


def _execute(named: NamedJob, folder: Path) -> Mapping[str, Any]:
    # Late: thread limits have to be set before the libraries that read them are imported.
    from recon.runs.events import Events
    from recon.runs.execute import execute

    events = Events(on_progress=lambda done, total: _listener[-1](named.name, done, total))
    return execute(named.job, folder, events, resume=is_begun(folder)).as_json()


def _names(named: NamedJob, folder: Path) -> tuple[tuple[str, str], ...]:
    """Pairs of true and assigned names, for a kind of job that knows the truth."""
    from recon.runs.job import KINDS

    return tuple(KINDS.load(named.job.kind).judged(named.job, folder))
