"""Everything that draws figures, loaded by importing this module: no thread starts, nothing is
drawn.
"""

import signal

from recon.libraries import keep_memory, limit_threads, load_unused_late
from recon.processes import collect_rarely


def _load() -> None:
    # First: most libraries read their limit when imported.
    limit_threads(1)
    collect_rarely()
    keep_memory()
    load_unused_late()
    if hasattr(signal, "pthread_sigmask"):  # Ctrl-C is handled by the process of the run
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    from recon.figures.canvas import load_libraries
    from recon.figures.table import KINDS
    from recon.runs.figure_file import ALWAYS

    for name in ALWAYS:
        KINDS.load(name)
    load_libraries()


_load()
