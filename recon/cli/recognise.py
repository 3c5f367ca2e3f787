"""`recon recognise`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import do_job
from recon.cli.options import OUTPUT, PATH, SETTINGS, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon recognise runs/village/map.npz")
@click.argument("file", type=PATH)
@click.option("--up", type=click.Choice(["y", "-y", "z", "-z"]), default="y", show_default=True)
@click.option("--recogniser", "recognition__recogniser", type=click.Choice(["robust", "thesis"]))
@click.option("--catalogue", "recognition__catalogue", help="TOML file of names and their rules.")
@with_options(SETTINGS, OUTPUT)
def recognise(file: Path, **given: Any) -> None:
    """Name the objects of a map or a cloud."""
    do_job("recognise", (file,), given, say=_say, up=given["up"])


def _say(report: "Report") -> None:
    for found in report["objects"]:
        place = ", ".join(f"{value:.2f}" for value in found["centre"])
        click.echo(f"{found['label']:14} at {place}   {found['probability']:.0%}")
    for reason, count in report["failures"].items():
        click.echo(f"not named: {count} x {reason}")
