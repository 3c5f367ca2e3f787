"""`recon reconstruct`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    FOLDER,
    MATCHING,
    OUTPUT,
    PATH,
    SETTINGS,
    build_settings,
    print_json,
    run_order,
    start_logging,
    with_options,
)
from recon.cli.progress import progress_bar


def parse_roi(
    _context: click.Context, _option: click.Parameter, text: str | None
) -> list[int] | None:
    """Pixels of "x,y,width,height"."""
    if text is None:
        return None
    words = text.split(",")
    if len(words) != 4 or not all(word.strip().isdecimal() for word in words):
        raise click.BadParameter(f"{text!r} is no region, but x,y,width,height are needed")
    return [int(word) for word in words]


@click.command(epilog="Example: recon reconstruct data/motorcycle -o runs/motorcycle")
@click.argument("sequence", type=PATH)
@click.option("--format", "sequence__format", help="auto, folder, kitti, euroc, ...")
@click.option("--poses", "sequence__poses", type=click.Choice(["given", "estimated", "none"]))
@click.option("--every", "sequence__every", type=click.IntRange(min=1), help="Every Nth pair.")
@click.option("--roi", "sequence__roi", metavar="X,Y,W,H", callback=parse_roi, help="In pixels.")
@with_options(MATCHING, SETTINGS, FOLDER, OUTPUT)
def reconstruct(sequence: Path, **given: Any) -> None:
    """Reconstruct what a calibrated stereo recording saw."""
    start_logging(given)
    from recon.runs.reconstruct import base_values, reconstruct_run

    settings = build_settings(given, base_values(sequence, given["sequence__format"] or "auto"))
    with progress_bar("pairs", given["quiet"]) as progress:
        order = run_order(given, sequence.resolve().name, progress)
        report = reconstruct_run(sequence, settings, order)
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        click.echo(
            f"{report['num_pairs']} pairs, {report['num_points']} points, "
            f"{report['num_voxels']} occupied cells"
        )
        click.echo(report["run"])
