"""The kinds of most jobs, loaded by importing this module: no thread starts, nothing is drawn."""

from recon.libraries import load_unused_late
from recon.processes import collect_rarely
from recon.runs.job import KINDS

collect_rarely()
load_unused_late()
for _kind in ("reconstruct", "explore"):
    KINDS.load(_kind)
