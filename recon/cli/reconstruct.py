"""`recon reconstruct`."""

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
    SETTINGS,
    SURFACE,
    run_folder,
    with_options,
)

if TYPE_CHECKING:
    from recon.runs.report import Report


def parse_roi(
    _context: click.Context, _option: click.Parameter, text: str | None
) -> list[int] | None:
    """Pixels of "x,y,width,height"."""
    if text is None:
        return None
    words = text.split(",")
    if len(words) != 4 or not all(word.strip().isdecimal() for word in words):
        raise click.BadParameter(f"{text!r} is not a region, but x,y,width,height are needed")
    return [int(word) for word in words]


@click.command(epilog="Example: recon reconstruct data/motorcycle -o runs/motorcycle")
@click.argument("sequence", type=PATH)
@click.option(
    "--format",
    "sequence__format",
    help="auto, folder, kitti, euroc, middlebury, ring, video, bag, simulated, or a plug-in.",
)
@click.option(
    "--poses",
    "sequence__poses",
    type=click.Choice(["given", "estimated", "none"]),
    help="Source of the poses.",
)
@click.option("--left-topic", "sequence__left_topic", help="Topic of the left images in a bag.")
@click.option("--right-topic", "sequence__right_topic", help="Topic of the right images in a bag.")
@click.option("--every", "sequence__every", type=click.IntRange(min=1), help="Read every Nth pair.")
@click.option(
    "--roi",
    "sequence__roi",
    metavar="X,Y,W,H",
    callback=parse_roi,
    help="Region of interest, pixels.",
)
@click.option(
    "-j",
    "num_workers",
    type=click.IntRange(min=1),
    help="Match pairs in N processes; threads, one per processor, by default.",
)
@click.option(
    "--chunk",
    type=click.IntRange(min=1),
    metavar="N",
    help="Hold N pairs in memory at a time and write a partitioned map.parquet of any size.",
)
@with_options(NAMES, MATCHING, SURFACE, SETTINGS, run_folder(), OUTPUT)
def reconstruct(sequence: Path, chunk: int | None, **given: Any) -> None:
    """Reconstruct a scene from a calibrated stereo recording."""
    do_job("reconstruct", (sequence,), given, say=_say, draws=True, chunk=chunk)


def _say(report: "Report") -> None:
    say_objects(report["objects"])
    click.echo(
        f"{counted(report['num_pairs'], 'pair')}, {counted(report['num_points'], 'point')}, "
        f"{counted(report['num_voxels'], 'occupied cell')}"
    )
    say_surface(report)
    click.echo(report.run)
