"""Everything that draws figures, loaded by importing this module: no thread starts, nothing is
drawn.
"""

import importlib
import signal

from recon.libraries import limit_threads
from recon.processes import collect_rarely


def _load() -> None:
    # First: most libraries read their limit when imported.
    limit_threads(1)
    collect_rarely()
    if hasattr(signal, "pthread_sigmask"):  # Ctrl-C is handled by the process of the run
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    from recon.figures.canvas import load_libraries
    from recon.figures.table import KINDS
    from recon.runs.figures import ALWAYS

    for name in ALWAYS:
        KINDS.load(name)
    load_libraries()
    _load_ground()


def _load_ground() -> None:
    """Load the compiled loops that floor plans need, by finding the ground of a flat square.

    Each process would load them again when most figures wait.
    """
    importlib.import_module("recon.figures.free_ground")
    import numpy as np

    from recon.recognition.segments.ground import NUM_VOTERS, level_plane

    x, z = np.divmod(np.arange(float(NUM_VOTERS)), 64.0)
    level_plane(np.column_stack([x, np.zeros_like(x), z]))


_load()
