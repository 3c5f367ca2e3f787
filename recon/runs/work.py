"""A running job: its folder, its stopwatch, and its observers."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from recon.runfolder import RunFolder
from recon.runs.artist import Artist
from recon.runs.events import Events
from recon.stopwatch import Stopwatch


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """Everything that the function of a `Kind` receives besides its job."""

    events: Events
    stopwatch: Stopwatch
    folder: RunFolder | None
    """The open run folder; None if not needed."""
    num_workers: int = 1
    """Number of parallel processes; the result does not depend on it."""
    artist: Artist = field(default_factory=Artist)
    """Draws the figures; a kind waits for them with `finish`."""

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Count the time inside the block for a stage."""
        return self.stopwatch.stage(name)

    @property
    def progress(self) -> Callable[[int, int], None]:
        """Report the progress of the job; raises `Cancelled` if it is to end."""
        return self.events.progress

    @property
    def run(self) -> RunFolder:
        """The run folder of a kind that always has one."""
        assert self.folder is not None
        return self.folder
