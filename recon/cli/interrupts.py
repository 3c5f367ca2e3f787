"""Signals that end a command, each treated like Ctrl-C, wherever it arrives."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
REPEAT_S = 0.5
"""Time after which a dropped interrupt is repeated."""


@contextmanager
def ending_as_ctrl_c() -> Iterator[None]:
    """Raise KeyboardInterrupt for signals that end the process, so that a run is closed properly.

    Signals that the caller ignores stay ignored, as with nohup. Libraries in machine code turn an
    interrupt into an error of their own, or drop it; the former becomes a KeyboardInterrupt again,
    the latter is repeated.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupts = _Interrupts()
    heeded = [one for one in ENDING_SIGNALS if signal.getsignal(one) is not signal.SIG_IGN]
    before = {one: signal.signal(one, interrupts.receive) for one in heeded}
    hook, sys.unraisablehook = sys.unraisablehook, interrupts.drop
    try:
        yield
    except Exception as error:
        if interrupts.received is not None:
            raise KeyboardInterrupt from error
        raise
    finally:
        interrupts.end()
        sys.unraisablehook = hook
        for one, handler in before.items():
            signal.signal(one, handler)


class _Interrupts:
    """The interrupts of a command."""

    def __init__(self) -> None:
        self.received: int | None = None
        self._repeats: list[threading.Timer] = []

    def receive(self, number: int, _frame: FrameType | None) -> NoReturn:
        """Handle a signal."""
        self.received = number
        raise KeyboardInterrupt

    def drop(self, dropped: Any) -> None:
        """Repeat an interrupt that Python dropped; other dropped errors are printed as usual."""
        if self.received is None or not issubclass(dropped.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(dropped)
            return
        main = threading.main_thread().ident
        repeat = threading.Timer(REPEAT_S, signal.pthread_kill, (main, self.received))
        repeat.daemon = True
        repeat.start()
        self._repeats.append(repeat)

    def end(self) -> None:
        """Repeat no more."""
        for repeat in self._repeats:
            repeat.cancel()
