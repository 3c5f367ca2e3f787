"""`recon recognise`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    OUTPUT,
    PATH,
    SETTINGS,
    build_settings,
    print_json,
    start_logging,
    with_options,
)


@click.command(epilog="Example: recon recognise runs/village/map.npz")
@click.argument("file", type=PATH)
@click.option("--up", type=click.Choice(["y", "-y", "z", "-z"]), default="y", show_default=True)
@click.option("--recogniser", "recognition__recogniser", type=click.Choice(["robust", "thesis"]))
@click.option("--catalogue", "recognition__catalogue", help="TOML file of names and their rules.")
@with_options(SETTINGS, OUTPUT)
def recognise(file: Path, **given: Any) -> None:
    """Name the objects of a map or a cloud."""
    start_logging(given)
    from recon.runs.clouds import recognise_run

    report = recognise_run(file, build_settings(given), up=given["up"])
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        for found in report["objects"]:
            place = ", ".join(f"{value:.2f}" for value in found["centre"])
            click.echo(f"{found['label']:14} at {place}   {found['probability']:.0%}")
        for reason, count in report["failures"].items():
            click.echo(f"not named: {count} x {reason}")
