"""A job at work: its folder, its clock, and those who watch it."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

from recon.runfolder import RunFolder
from recon.runs.events import Events
from recon.stopwatch import Stopwatch


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """Everything that the function of a `Kind` is handed besides its job."""

    events: Events
    stopwatch: Stopwatch
    folder: RunFolder | None
    """The run folder, open; None where none is wanted."""
    num_workers: int = 1
    """Processes that may work at once; what comes of it does not depend on them."""

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Count what happens inside for a stage."""
        return self.stopwatch.stage(name)

    @property
    def progress(self) -> Callable[[int, int], None]:
        """Say how far the job is; raises `Cancelled` where it is to end."""
        return self.events.progress

    @property
    def run(self) -> RunFolder:
        """The run folder of a kind that always has one."""
        assert self.folder is not None
        return self.folder
