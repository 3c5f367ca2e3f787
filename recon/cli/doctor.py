"""`recon doctor`."""

import time

import click

from recon.cli.options import OUTPUT, print_json, start_logging, with_options
from recon.cli.progress import shown_progress
from recon.errors import ReconError


@click.command(epilog="Example: recon doctor")
@click.option(
    "--compile", "compiles", is_flag=True, help="Compile now what the first run would compile."
)
@with_options(OUTPUT)
def doctor(compiles: bool, as_json: bool, quiet: bool, verbose: bool) -> None:
    """Check that this machine has what recon needs, and how to install what is missing."""
    start_logging({"quiet": quiet, "verbose": verbose})
    if compiles:
        _compile(quiet)
    from recon.runs.doctor import examine

    checks = examine()
    if as_json:
        print_json({"checks": [check.as_json() for check in checks]})
    elif not quiet:
        for check in checks:
            click.echo(f"{_state(check.is_ok, check.is_needed):8} {check.name:12} {check.message}")
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
        click.echo(f"recon: all kernels are compiled ({seconds:.0f} s)", err=True)


def _state(is_ok: bool, is_needed: bool) -> str:
    """The status of a check in one word."""
    if is_ok:
        return "ok"
    return "MISSING" if is_needed else "optional"
