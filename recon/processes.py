"""Worker processes: with their share of the threads, and no longer alive than their parent."""

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


def _end_after(sentinel: int) -> None:
    """End this process at once when another has ended."""
    wait([sentinel])
    os._exit(1)
