"""Worker processes: with their share of the threads, and no longer alive than their parent."""

import gc
import os
import threading
from multiprocessing import parent_process
from multiprocessing.connection import wait

from recon.libraries import limit_threads


def begin_worker(num_threads: int) -> None:
    """Set up a worker process; call it before other libraries are imported.

    A pool's worker waits for work forever, even if the process that would give it was killed; one
    in the middle of a job would keep its run folder locked.
    """
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()
    limit_threads(num_threads)
    collect_rarely()


def collect_rarely() -> None:
    """Look for cyclic garbage after more objects: imports make lasting ones only, and many.

    By default the collections take a fifth of the time of the imports.
    """
    gc.set_threshold(10_000)


def _end_after(sentinel: int) -> None:
    """End this process at once when another has ended."""
    wait([sentinel])
    os._exit(1)
