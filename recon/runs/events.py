"""Events of a running job, and its cancellation by the caller."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from recon.mapping.mapper import Step


class Cancelled(KeyboardInterrupt):
    """The caller cancelled the job, as with Ctrl-C."""


def _ignore(*_: object) -> None:
    """Ignore the event."""


def _never() -> bool:
    return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Events:
    """Callbacks of a running job, called from its thread."""

    on_step: Callable[["Step"], None] = _ignore
    """Called when one more pair is in the map."""
    on_stage: Callable[[str], None] = _ignore
    """Called when another stage starts: compiling, reading, stereo, map, recognise, figures, write,
    ..."""
    on_progress: Callable[[int, int], None] = _ignore
    """Called with the numbers of items done and of all items, an upper bound."""
    is_cancelled: Callable[[], bool] = _never
    """Called between pairs: true ends the job."""

    def progress(self, done: int, total: int) -> None:
        """Report the progress of the job.

        Raises
        ------
        Cancelled
            If the caller cancels the job.
        """
        self.on_progress(done, total)
        if self.is_cancelled():
            raise Cancelled
