"""Events of a running job, and the caller's way to end it."""

from collections.abc import Callable
from dataclasses import dataclass

from recon.mapping.mapper import Step


class Cancelled(KeyboardInterrupt):
    """The caller wanted the job to end, as Ctrl-C does."""


def _unheard(*_: object) -> None:
    """Nobody listens."""


def _never() -> bool:
    return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Events:
    """Functions that a running job calls, from the thread it runs in."""

    on_step: Callable[[Step], None] = _unheard
    """One more pair is in the map."""
    on_stage: Callable[[str], None] = _unheard
    """Another stage runs: compiling, reading, stereo, map, recognise, figures, write, ..."""
    on_progress: Callable[[int, int], None] = _unheard
    """So many of so many, at most, are done."""
    is_cancelled: Callable[[], bool] = _never
    """Asked between pairs: true ends the job."""

    def progress(self, done: int, total: int) -> None:
        """Say how far the job is.

        Raises
        ------
        Cancelled
            Where the caller wants it to end.
        """
        self.on_progress(done, total)
        if self.is_cancelled():
            raise Cancelled
