"""`recon recognise`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import do_job
from recon.cli.objects import say_objects
from recon.cli.options import NAMES, OUTPUT, PATH, SETTINGS, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon recognise runs/village --catalogue village")
@click.argument("file", type=PATH)
@click.option(
    "--up", type=click.Choice(["y", "-y", "z", "-z"]), default="y", show_default=True,
    help="Direction that is up in FILE.",
)  # fmt: skip
@click.option(
    "--unit", "recognition__unit", type=click.Choice(["m"]), help="Unit of length in FILE."
)
@click.option(
    "-o", "--output", "cloud", type=PATH, help="Save the cloud with a column `object`, as PLY."
)
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@with_options(NAMES, SETTINGS, OUTPUT)
def recognise(file: Path, cloud: Path | None, **given: Any) -> None:
    """Find and name the objects in a cloud, a map or a run."""
    overwrite = given.pop("overwrite")
    cloud_name = None if cloud is None else str(cloud)
    do_job(
        "recognise", (file,), given, say=_say, up=given["up"], cloud=cloud_name,
        overwrite=overwrite,
    )  # fmt: skip


def _say(report: "Report") -> None:
    say_objects(report["objects"])
    if not report["objects"]:
        click.echo("no objects")
    for reason, count in report["failures"].items():
        click.echo(f"not named: {count} x {reason}")
