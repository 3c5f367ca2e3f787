"""The command line: arguments, one call per command, output, exit codes."""

import os
import sys

# Before numpy is loaded: threads slow the small products down, and change their last bits.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from recon.cli import ending as ending  # registers itself before all that is loaded next

try:
    from recon.cli.main import entry, main
except KeyboardInterrupt:  # loading the commands takes a moment
    sys.stderr.write("recon: interrupted\n")
    sys.exit(130)

__all__ = ["entry", "main"]
