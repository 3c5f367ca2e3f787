"""Worker processes: with their share of the threads, and no longer alive than their parent."""

import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from multiprocessing.context import BaseContext

from recon.libraries import limit_threads

SPAWN: BaseContext = get_context("spawn")


def start_server(*modules: str) -> BaseContext:
    """Start the process that workers are forked from, and return the way to start them.

    Where the system can fork safely, it loads modules with everything that the workers need, while
    this process does other things; it ends with this process. Its environment is that of its start,
    and there is one: it is for programs that run one command.
    """
    if sys.platform != "linux":
        return SPAWN
    from multiprocessing import forkserver, resource_tracker

    context = get_context("forkserver")
    context.set_forkserver_preload(list(modules))
    resource_tracker.ensure_running()  # it changes the mask of signals itself
    with _ctrl_c_held_back():
        forkserver.ensure_running()
    return context


@contextmanager
def _ctrl_c_held_back() -> Iterator[None]:
    """Let processes that start in the block wait with Ctrl-C until they are set up.

    The server ignores it, but only when it has loaded its modules; until then it would end with a
    traceback.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def begin_worker(num_threads: int) -> None:
    """Set up a worker process; call it before other libraries are imported.

    A pool's worker waits for work forever, even if the process that would give it was killed; one
    in the middle of a job would keep its run folder locked.
    """
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()
    limit_threads(num_threads)
    collect_rarely()


def collect_rarely() -> None:
    """Collect cyclic garbage less often: imports create many objects, all of them lasting.

    By default the collections take a fifth of the time of the imports.
    """
    gc.set_threshold(50_000)


def _end_after(sentinel: int) -> None:
    """End this process at once when another has ended."""
    wait([sentinel])
    os._exit(1)
