"""`recon localise`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import counted, do_job
from recon.cli.options import OUTPUT, PATH, QUALITY, SETTINGS, with_options

if TYPE_CHECKING:
    from recon.runs.report import Report


@click.command(epilog="Example: recon localise runs/drive today")
@click.argument("run", type=PATH)
@click.argument("pairs", type=PATH)
@click.option("--recording", type=PATH, help="Present location of the run's recording or scene.")
@QUALITY
@with_options(SETTINGS, OUTPUT)
def localise(run: Path, pairs: Path, **given: Any) -> None:
    """Find where pairs were taken in the map of a run.

    PAIRS is one pair or a sequence, in any format that `recon reconstruct` reads. No initial guess
    is needed; pairs that fit no place, or more than one, are reported as such.
    """
    do_job("localise", (run, pairs), given, say=_say, recording=given["recording"])


def _say(report: "Report") -> None:
    poses = report["poses"]
    for one in poses:
        click.echo(f"{one['name']}  {_where(one)}")
    click.echo(f"{report['num_found']} of {counted(len(poses), 'pair')} found")


def _where(one: dict[str, Any]) -> str:
    if one["T_world_left"] is None:
        return f"not found: {one['reason']}"
    x, y, z = (row[3] for row in one["T_world_left"][:3])
    return (
        f"x {x:.3f}  y {y:.3f}  z {z:.3f}  sigma {one['sigma']:.3f}, {one['sigma_deg']:.2f} deg  "
        f"probability {one['probability']:.2f}"
    )
