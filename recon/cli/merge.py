"""`recon merge`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.objects import say_objects
from recon.cli.options import FOLDER, NAMES, OUTPUT, PATH, SETTINGS, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon merge runs/north runs/south -o runs/city")
@click.argument("runs", nargs=-1, required=True, type=PATH, metavar="RUN...")
@with_options(NAMES, SETTINGS, FOLDER, OUTPUT)
def merge(runs: tuple[Path, ...], **given: Any) -> None:
    """Put runs of one world together: one map in partitions, larger than any memory.

    The runs have one frame, as of given poses, and one size of cells.
    """
    do_job("merge", runs, given, say=_say, unit="runs")


def _say(report: "Report") -> None:
    say_objects(report["objects"])
    click.echo(
        f"{counted(report['num_runs'], 'run')}, {counted(report['num_pairs'], 'pair')}, "
        f"{counted(report['num_points'], 'point')}, "
        f"{counted(report['num_voxels'], 'occupied cell')}"
    )
    click.echo(report.run)
