"""`recon figure`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, FiniteRange, with_options
from recon.cli.output import print_document, start_logging
from recon.figures.table import KINDS

MIN_SIDE, MAX_SIDE = 100, 8192
VIEWS = "default, front, back, side, top, ego (behind the first camera), camera (the camera's)"


def parse_size(
    _context: click.Context, _option: click.Parameter, text: str | None
) -> tuple[int, int] | None:
    """Width and height of "WxH", pixels."""
    if text is None:
        return None
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise click.BadParameter(f"{text!r} is not a size, but WxH such as 1200x900 is needed")
    if not all(MIN_SIDE <= int(side) <= MAX_SIDE for side in (width, height)):
        raise click.BadParameter(f"{text} is out of range: {MIN_SIDE} to {MAX_SIDE} pixels a side")
    return int(width), int(height)


@click.command(epilog="Example: recon figure runs/village --kind map3d --view top --format pdf")
@click.argument("run", type=PATH)
@click.option("--kind", help=f"{', '.join(KINDS.names())}; default: all that the run has.")
@click.option(
    "--view", default="default",
    help=f"View in 3D: {VIEWS}, a viewpoint x,y,z, or a viewpoint and a target, x,y,z,x,y,z.",
)  # fmt: skip
@click.option(
    "--size",
    metavar="WxH",
    callback=parse_size,
    help="Size in pixels, such as 1200x900; depends on the kind by default.",
)
@click.option(
    "--format",
    "ending",
    type=click.Choice(["png", "pdf", "svg"]),
    default="png",
    show_default=True,
    help="Format of the file.",
)
@click.option("--dpi", type=click.IntRange(30, 1200), default=100, show_default=True,
              help="Resolution of the printed figure, dots per inch.")  # fmt: skip
@click.option(
    "--font-size",
    type=FiniteRange(3, 72),
    help="Font size in points; follows --size by default.",
)
@click.option("--no-title", is_flag=True, help="Draw no title.")
@click.option(
    "--background",
    type=click.Choice(["white", "transparent"]),
    default="white",
    show_default=True,
    help="Background of the figure.",
)
@click.option("--data", "with_data", is_flag=True,
              help="Also save the data as .npz; labels also as GeoJSON and nav2 map.")  # fmt: skip
@with_options(OUTPUT)
def figure(run: Path, **given: Any) -> None:
    """Redraw the figures of a run."""
    start_logging(given)
    from recon.figures.canvas import Style
    from recon.runs.figure_file import FigureRequest
    from recon.runs.figures import figure_run

    style = Style(
        dpi=given["dpi"], font_size=given["font_size"], with_title=not given["no_title"],
        background=given["background"],
    )  # fmt: skip
    request = FigureRequest(
        kind=given["kind"], view=given["view"], size=given["size"], style=style,
        ending=given["ending"], with_data=given["with_data"],
    )  # fmt: skip
    paths = figure_run(run, request)
    print_document(given, {"figures": [str(path) for path in paths]}, paths)
