"""Drawing of figures: by this process, or by a second one while the run goes on."""

import gc
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from typing import Any, Literal

from recon.processes import begin_worker

Call = tuple[Callable[..., object], tuple[Any, ...]]
"""A function that writes figures, and its arguments."""


class Artist:
    """Draws the figures of a run, in the order in which they are requested."""

    def draw(self, call: Callable[..., object], *arguments: Any) -> None:
        """Request a call that writes figures."""
        call(*arguments)

    def finish(self) -> None:
        """Wait for all figures; raises what their calls raised."""

    def close(self) -> None:
        """End the work, whether or not it is finished."""


class SecondProcess(Artist):
    """Draws in another process, which prepares for it ahead.

    A process that has loaded nothing that threads or draws yet is forked, so that only the rest is
    loaded twice. Otherwise the new process imports the main module: a program without a guard would
    start again.

    Parameters
    ----------
    prepare : callable
        What the process does first, as loading libraries.
    """

    def __init__(self, prepare: Callable[[], object]) -> None:
        self.start_method: Literal["fork", "spawn"] = "fork" if _may_fork() else "spawn"
        context = get_context("fork") if self.start_method == "fork" else get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _without_ctrl_c(), warnings.catch_warnings():
            # Python 3.12 warns of any thread; those of BLAS end before a fork.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        theirs.close()
        self._send(prepare)
        self._waiting: list[Call] = []

    def draw(self, call: Callable[..., object], *arguments: Any) -> None:
        """Request a call that writes figures."""
        self._waiting.append((call, arguments))
        self._send((call, arguments))

    def finish(self) -> None:
        """Wait for all figures; those of a process that was killed are drawn by this one."""
        while self._waiting:
            call, arguments = self._waiting.pop(0)
            try:
                error = self._pipe.recv()
            except (EOFError, ConnectionResetError):
                call(*arguments)
            else:
                if error is not None:
                    raise error

    def close(self) -> None:
        """End the process, whether or not it is finished."""
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def _send(self, message: object) -> None:
        """Send a message; a process that has ended is noticed when figures are waited for."""
        with suppress(BrokenPipeError):
            self._pipe.send(message)


_UNFORKABLE = "vtkmodules", "open3d"
"""Libraries whose own threads a fork would lose."""


def _may_fork() -> bool:
    """True on Linux, as long as there is one thread and no library that draws or threads."""
    is_fresh = not any(name in sys.modules for name in _UNFORKABLE)
    return sys.platform == "linux" and threading.active_count() == 1 and is_fresh


@contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Hold Ctrl-C back inside the block, and in the processes that it starts."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection) -> None:
    """Do the calls until the process is ended; Ctrl-C is for the first process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for ending in ("SIGTERM", "SIGHUP"):  # a fork has the handlers of the first process
        if hasattr(signal, ending):
            signal.signal(getattr(signal, ending), signal.SIG_DFL)
    gc.freeze()
    begin_worker(1)
    calls: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_receive, args=(pipe, calls), daemon=True).start()
    # Functions are loaded with their modules: the limit of threads has to be set before.
    prepare = ForkingPickler.loads(calls.get())
    prepare()
    while True:
        call, arguments = ForkingPickler.loads(calls.get())
        try:
            call(*arguments)
        # Raised again where the figures are waited for.
        except Exception as error:
            pipe.send(error)
        else:
            pipe.send(None)


def _receive(pipe: Connection, calls: "SimpleQueue[bytes]") -> None:
    """Take calls at once, so that nobody waits to request them."""
    with suppress(EOFError, OSError):
        while True:
            calls.put(pipe.recv_bytes())
