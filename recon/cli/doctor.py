"""`recon doctor`."""

import click

from recon.cli.options import OUTPUT, print_json, start_logging, with_options
from recon.errors import ReconError


@click.command(epilog="Example: recon doctor")
@with_options(OUTPUT)
def doctor(as_json: bool, quiet: bool, verbose: bool) -> None:
    """Check that this machine has what recon needs, and say what cures what is missing."""
    start_logging({"quiet": quiet, "verbose": verbose})
    from recon.runs.doctor import examine

    findings = examine()
    if as_json:
        print_json({"checks": [finding.as_json() for finding in findings]})
    elif not quiet:
        for finding in findings:
            click.echo(
                f"{'ok' if finding.is_well else 'MISSING':8} {finding.name:12} {finding.word}"
            )
    faults = [finding.word for finding in findings if not finding.is_well and finding.is_needed]
    if faults:
        raise ReconError(faults[0])
