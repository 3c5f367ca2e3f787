"""`recon mesh`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.options import (
    OUTPUT,
    PATH,
    QUALITY,
    SETTINGS,
    SURFACE_FORM,
    run_folder,
    with_options,
)

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon mesh runs/motorcycle -o runs/motorcycle_mesh")
@click.argument("run", type=PATH)
@click.option("--recording", type=PATH, help="Present location of the run's recording or scene.")
@QUALITY
@with_options(SURFACE_FORM, SETTINGS, run_folder("runs/NAME_mesh"), OUTPUT)
def mesh(run: Path, **given: Any) -> None:
    """Make a mesh for a finished run with poses, from its recording or simulated world."""
    do_job("mesh", (run,), given, say=_say, recording=given["recording"])


def _say(report: "Report") -> None:
    say_surface(report)
    click.echo(report.run)


def say_surface(report: "Report") -> None:
    """Print a summary of a surface."""
    if "num_dense_points" in report.numbers:
        click.echo(counted(report["num_dense_points"], "dense point"))
    if "num_triangles" in report.numbers:
        triangles = counted(report["num_triangles"], "triangle")
        click.echo(f"{triangles}, area {report['mesh_area']:.6g}")
