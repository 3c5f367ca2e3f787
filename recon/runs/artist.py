"""Drawing of figures: by this process, or by others while the run continues."""

import os
import signal
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.context import BaseContext
from typing import Any

from recon.processes import begin_worker, start_server

Call = tuple[Callable[..., object], tuple[Any, ...]]
"""A function that writes a figure, and its arguments."""

NICENESS = 10
"""Of 19 that processes may have that yield to others."""


class Artist:
    """Draws the figures of a run, in the order in which they are requested."""

    def draw(self, call: Callable[..., object], *arguments: Any) -> None:
        """Request a call that writes a figure."""
        call(*arguments)

    def finish(self) -> None:
        """Wait for all figures; raises what their calls raised."""

    def close(self) -> None:
        """Drop the figures not begun, and wait for the others."""


class OtherProcesses(Artist):
    """Draws in other processes, some figures at once.

    Parameters
    ----------
    start : multiprocessing context
        The way to start them, as returned by `start_drawing`.
    number : int
        Maximum number of figures drawn at once.
    """

    def __init__(self, start: BaseContext, number: int = 2) -> None:
        self._pool = ProcessPoolExecutor(number, mp_context=start, initializer=_begin)
        self._waiting: list[tuple[Future[object], Call]] = []

    def draw(self, call: Callable[..., object], *arguments: Any) -> None:
        """Request a call that writes a figure."""
        try:
            figure = self._pool.submit(call, *arguments)
        except BrokenProcessPool:
            call(*arguments)
        else:
            self._waiting.append((figure, (call, arguments)))

    def finish(self) -> None:
        """Wait for all figures; those of a process that was killed are drawn by this one."""
        while self._waiting:
            figure, (call, arguments) = self._waiting.pop(0)
            try:
                figure.result()
            except BrokenProcessPool:
                call(*arguments)

    def close(self) -> None:
        """Drop the figures not begun, and wait for the others."""
        self._pool.shutdown(cancel_futures=True)


def start_drawing() -> BaseContext:
    """Start the process that drawing ones are forked from, with their libraries loaded."""
    return start_server("recon.runs.drawing")


def _begin() -> None:
    """Set up a process; Ctrl-C is handled by the main one, which waits for it.

    It yields the processor to the run, which figures without objects need not delay.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    begin_worker(1)
