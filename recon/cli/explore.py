"""`recon explore`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.mesh import say_surface
from recon.cli.objects import say_objects
from recon.cli.options import (
    MATCHING,
    NAMES,
    OUTPUT,
    PATH,
    SCENE,
    SETTINGS,
    SURFACE,
    run_folder,
    with_options,
)

if TYPE_CHECKING:
    from recon.runs.report import Report

PROGRESS = "% of the floor"


@click.command(epilog="Example: recon explore village -o runs/village")
@click.argument("scene", type=PATH)
@click.option("--controller", "exploration__controller", help="frontier, thesis, or a plug-in.")
@click.option("--renderer", "render__renderer", help="raycast, filament, or a plug-in.")
@click.option(
    "--max-pairs",
    "exploration__max_pairs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Stop after N pairs.",
)
@with_options(NAMES, MATCHING, SURFACE, SCENE, SETTINGS, run_folder(), OUTPUT)
def explore(scene: Path, **given: Any) -> None:
    """Explore a simulated world, map it and name its objects.

    SCENE is a geometry file, or the name of a scene that ships with recon.
    """
    do_job("explore", (scene,), given, say=say_exploration, draws=True, unit=PROGRESS)


def say_exploration(report: "Report") -> None:
    """Print the objects found, and how the exploration ended."""
    say_objects(report["objects"])
    click.echo(
        f"{counted(report['num_pairs'], 'pair')}, {counted(report['num_points'], 'point')}, "
        f"{report['coverage']:.0%} of the floor known; stopped: {report['stop_reason']}"
    )
    say_surface(report)
    click.echo(report.run)
