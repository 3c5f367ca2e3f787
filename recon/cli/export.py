"""`recon export`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, with_options
from recon.cli.output import print_document, start_logging


def parse_box(
    _context: click.Context, _option: click.Parameter, text: str | None
) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Low and high corner of "x0,y0,z0,x1,y1,z1"."""
    if text is None:
        return None
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    low, high = numbers[:3], numbers[3:]
    if len(numbers) != 6 or not all(a < b for a, b in zip(low, high, strict=True)):
        raise click.BadParameter(
            f"{text!r} is not a box, but x0,y0,z0,x1,y1,z1 are needed, "
            "with x0 < x1, y0 < y1 and z0 < z1"
        )
    return low, high


@click.command(epilog="Example: recon export runs/village/map.npz village.glb")
@click.argument("source", metavar="IN", type=PATH)
@click.argument("target", metavar="OUT", type=PATH)
@click.option(
    "--box",
    metavar="X0,Y0,Z0,X1,Y1,Z1",
    callback=parse_box,
    help="Keep only what lies inside, in the axes of IN.",
)
@click.option("--up", type=click.Choice(["y", "z"]), help="Axis that points up in OUT.")
@click.option(
    "--sample",
    type=click.IntRange(min=1),
    metavar="N",
    help="Take N points of a cloud, or sample N evenly from the surface of a mesh.",
)
@click.option(
    "--columns",
    metavar="NAME,...",
    help="Columns of a text table, such as x,y,z,intensity; _ skips one.",
)
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@with_options(OUTPUT)
def export(source: Path, target: Path, **given: Any) -> None:
    """Convert a map, a cloud or a mesh to the format that the suffix of OUT names."""
    start_logging(given)
    from recon.runs.export import Selection, export_run

    report = export_run(
        source,
        target,
        selection=Selection(
            box=given["box"],
            columns=given["columns"] and given["columns"].split(","),
            sample=given["sample"],
        ),
        up=given["up"],
        overwrite=given["overwrite"],
    )
    line = f"{report['output']}, {report['up']} up, {report['bytes']} bytes"
    print_document(given, report, [line])
