"""`recon fit`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, with_options
from recon.cli.output import print_document, start_logging


@click.command(epilog="Example: recon fit part.ply --json")
@click.argument("file", type=PATH)
@with_options(OUTPUT)
def fit(file: Path, **given: Any) -> None:
    """Fit one solid to one cloud: sphere, ellipsoid, cylinder, cone, plane or box."""
    start_logging(given)
    from recon.runs.fit import fit_run

    report = fit_run(file)
    share = f"{report['explained']:.0%} of the points"
    lines = [
        f"{report['shape']}, rms {report['rms']:.4g}, explains {share}",
        *(f"  {name:14} {value}" for name, value in report["parameters"].items()),
    ]
    print_document(given, report, lines)
