"""`recon doctor`."""

import time
from typing import Any

import click

from recon.cli.options import REPORT, with_options
from recon.cli.output import print_document, start_logging
from recon.cli.progress import shown_progress
from recon.errors import ReconError


@click.command(epilog="Example: recon doctor")
@click.option(
    "--compile", "compiles", is_flag=True, help="Compile now what the first run would compile."
)
@with_options(REPORT)
def doctor(compiles: bool, **given: Any) -> None:
    """Check that this machine has what recon needs, and how to install what is missing."""
    start_logging(given)
    if compiles:
        _compile(given["quiet"])
    from recon.runs.doctor import examine

    checks = examine()
    lines = (
        f"{_state(check.is_ok, check.is_needed):8} {check.name:12} {check.message}"
        for check in checks
    )
    print_document(given, {"checks": [check.as_json() for check in checks]}, lines)
    faults = [check.message for check in checks if not check.is_ok and check.is_needed]
    if faults:
        raise ReconError(faults[0])


def _compile(quiet: bool) -> None:
    """Compile in advance, with a progress bar and a final line."""
    from recon.runs.compile import compile_ahead

    began = time.perf_counter()
    with shown_progress("jobs", quiet) as events:
        compile_ahead(events)
    if not quiet:
        seconds = time.perf_counter() - began
        click.echo(f"recon: what a first run compiles is compiled ({seconds:.0f} s)", err=True)


def _state(is_ok: bool, is_needed: bool) -> str:
    """The status of a check in one word."""
    if is_ok:
        return "ok"
    return "MISSING" if is_needed else "optional"
