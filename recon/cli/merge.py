"""`recon merge`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.objects import say_objects
from recon.cli.options import NAMES, OUTPUT, PATH, SETTINGS, run_folder, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon merge runs/north runs/south -o runs/city")
@click.argument("runs", nargs=-1, required=True, type=PATH, metavar="RUN...")
@with_options(NAMES, SETTINGS, run_folder("runs/merged"), OUTPUT)
def merge(runs: tuple[Path, ...], **given: Any) -> None:
    """Merge runs of the same world into one partitioned map of any size.

    The runs must share one world frame, as given poses do, and one cell size.
    """
    do_job("merge", runs, given, say=_say, draws=True, unit="runs")


def _say(report: "Report") -> None:
    say_objects(report["objects"])
    click.echo(
        f"{counted(report['num_runs'], 'run')}, {counted(report['num_pairs'], 'pair')}, "
        f"{counted(report['num_points'], 'point')}, "
        f"{counted(report['num_voxels'], 'occupied cell')}"
    )
    click.echo(report.run)
