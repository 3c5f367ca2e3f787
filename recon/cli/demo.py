"""`recon demo`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.explore import PROGRESS, say_exploration
from recon.cli.jobs import do_job
from recon.cli.options import OUTPUT, SETTINGS, run_folder, with_options

SCENE = Path("village")


@click.command(epilog="Example: recon demo")
@with_options(SETTINGS, run_folder("runs/village"), OUTPUT)
def demo(**given: Any) -> None:
    """Explore the village that ships with recon, into runs/village."""
    do_job("explore", (SCENE,), given, say=say_exploration, draws=True, unit=PROGRESS)
    if not (given["as_json"] or given["quiet"]):
        click.echo("Start with figures/overview.png in it.")
