"""Signals that end a command, each treated like Ctrl-C, wherever it arrives."""

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

ENDING_SIGNALS = (signal.SIGTERM, signal.SIGHUP)
REPEAT_S = 0.5
"""Time after which a lost interrupt is repeated."""


@contextmanager
def ending_as_ctrl_c() -> Iterator[None]:
    """Raise KeyboardInterrupt for signals that end the process, so that a run is closed properly.

    The compiler of kernels calls back from machine code, where Python drops an interrupt: the
    compiler then fails in its own words, or goes on. The one becomes a KeyboardInterrupt, for the
    other the interrupt is repeated.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {one: signal.signal(one, signal.default_int_handler) for one in ENDING_SIGNALS}
    lost = _LostInterrupts()
    hook, sys.unraisablehook = sys.unraisablehook, lost
    try:
        yield
    except Exception as error:
        if lost.repeats:
            raise KeyboardInterrupt from error
        raise
    finally:
        lost.end()
        sys.unraisablehook = hook
        for one, handler in before.items():
            signal.signal(one, handler)


class _LostInterrupts:
    """Repeats every interrupt that Python dropped; other dropped errors are printed as usual."""

    def __init__(self) -> None:
        self.repeats: list[threading.Timer] = []

    def __call__(self, dropped: Any) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(dropped)
            return
        repeat = threading.Timer(REPEAT_S, _thread.interrupt_main)
        repeat.daemon = True
        repeat.start()
        self.repeats.append(repeat)

    def end(self) -> None:
        """Repeat no more."""
        for repeat in self.repeats:
            repeat.cancel()
