"""The command line: arguments, one call a command, prints, exit codes."""

from recon.cli.main import entry, main

__all__ = ["entry", "main"]
