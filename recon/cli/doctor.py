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

    findings = examine()
    if as_json:
        print_json({"checks": [finding.as_json() for finding in findings]})
    elif not quiet:
        for finding in findings:
            click.echo(
                f"{_state(finding.is_well, finding.is_needed):8} {finding.name:12} {finding.word}"
            )
    faults = [finding.word for finding in findings if not finding.is_well and finding.is_needed]
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


def _state(is_well: bool, is_needed: bool) -> str:
    """The status of a finding in one word."""
    if is_well:
        return "ok"
    return "MISSING" if is_needed else "optional"
