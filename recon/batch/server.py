"""The process that workers are forked from, after it has loaded what their jobs need."""

import sys
from multiprocessing import get_context
from multiprocessing.context import BaseContext

SPAWN: BaseContext = get_context("spawn")


def start_server() -> BaseContext:
    """Start the process if the system can fork safely, and return the way to start workers.

    It loads meanwhile, and ends with this process. Its environment is that of its start: it is for
    programs that run one batch.
    """
    if sys.platform != "linux":
        return SPAWN
    from multiprocessing.forkserver import ensure_running

    context = get_context("forkserver")
    context.set_forkserver_preload(["recon.batch.loaded"])
    ensure_running()
    return context
