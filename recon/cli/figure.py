"""`recon figure`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, print_json, start_logging, with_options

MIN_SIDE, MAX_SIDE = 100, 8192


@click.command(epilog="Example: recon figure runs/village --kind map3d --view top")
@click.argument("run", type=PATH)
@click.option("--kind", help="map3d, solids, parts, counts, slices, occupancy, ...")
@click.option("--view", default="default", help="default, top, front or side, of map3d.")
@click.option("--data", "with_data", is_flag=True, help="Also the arrays that are drawn, as .npz.")
@click.option("--size", metavar="WxH", help="Pixels, as 1200x900.")
@with_options(OUTPUT)
def figure(run: Path, **given: Any) -> None:
    """Draw the figures of a run again."""
    start_logging(given)
    from recon.runs.figures import figure_run

    paths = figure_run(
        run, kind=given["kind"], view=given["view"], size=_parse_size(given["size"]),
        with_data=given["with_data"],
    )  # fmt: skip
    if given["as_json"]:
        print_json({"figures": [str(path) for path in paths]})
    elif not given["quiet"]:
        for path in paths:
            click.echo(path)


def _parse_size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise click.BadParameter(f"{text!r} is no size, but WxH such as 1200x900 is needed")
    if not all(MIN_SIDE <= int(side) <= MAX_SIDE for side in (width, height)):
        raise click.BadParameter(f"{text} is out of range: {MIN_SIDE} to {MAX_SIDE} pixels a side")
    return int(width), int(height)
