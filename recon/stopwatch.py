"""A stopwatch that splits the wall time of a run into stages."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from recon.libraries import listening_to_compiler

FIRST_STAGE = "reading"
"""The stage that runs while no other does: unnamed time is spent reading input."""


def ignore(stage: str) -> None:
    """Ignore the stage."""


class Stopwatch:
    """Wall time by stage; at every moment exactly one stage runs, so they add up to the total.

    Parameters
    ----------
    on_stage : callable
        Called with the name of every stage that begins or resumes.
    """

    def __init__(self, on_stage: Callable[[str], None] = ignore) -> None:
        self._on_stage = on_stage
        self._seconds: dict[str, float] = {}
        self._stage = FIRST_STAGE
        self._since = time.perf_counter()
        self._owner = threading.get_ident()

    @property
    def seconds(self) -> dict[str, float]:
        """Time of each stage so far, and their `total`."""
        self._switch(self._stage)
        return self._seconds | {"total": sum(self._seconds.values())}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time inside the block for one stage, and after it for the previous one."""
        outer = self._enter(name)
        try:
            yield
        finally:
            self._enter(outer)

    @contextmanager
    def counting_compilation(self) -> Iterator[None]:
        """Count kernel compilation inside the block for the stage `compiling`."""
        outer: list[str] = []

        def begin() -> None:
            if threading.get_ident() == self._owner:
                outer.append(self._enter("compiling"))

        def end() -> None:
            if outer and threading.get_ident() == self._owner:
                self._enter(outer.pop())

        with listening_to_compiler(begin, end):
            yield

    def _enter(self, stage: str) -> str:
        """Change the stage and return the previous one."""
        before = self._switch(stage)
        if stage != before:
            self._on_stage(stage)
        return before

    def _switch(self, stage: str) -> str:
        before, now = self._stage, time.perf_counter()
        self._seconds[before] = self._seconds.get(before, 0.0) + now - self._since
        self._stage, self._since = stage, now
        return before
