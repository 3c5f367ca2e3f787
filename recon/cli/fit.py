"""`recon fit`."""

from pathlib import Path

import click

from recon.cli.options import OUTPUT, PATH, print_json, start_logging, with_options


@click.command(epilog="Example: recon fit part.ply --json")
@click.argument("file", type=PATH)
@with_options(OUTPUT)
def fit(file: Path, as_json: bool, quiet: bool, verbose: bool) -> None:
    """Fit one solid to one cloud: sphere, ellipsoid, cylinder, cone, plane or box."""
    start_logging({"quiet": quiet, "verbose": verbose})
    from recon.runs.fit import fit_run

    report = fit_run(file)
    if as_json:
        print_json(report)
    elif not quiet:
        share = f"{report['explained']:.0%} of the points"
        click.echo(f"{report['shape']}, rms {report['rms']:.4g}, explains {share}")
        for name, value in report["parameters"].items():
            click.echo(f"  {name:14} {value}")
