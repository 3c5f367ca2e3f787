"""The command line: arguments, one call per command, output, exit codes."""

import os

# Before numpy is loaded: threads slow the small products down, and change their last bits.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from recon.cli import ending as ending  # registers itself before all that is loaded next
from recon.cli.main import entry, main

__all__ = ["entry", "main"]
