"""`recon calibrate`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, PositiveNumber, print_json, start_logging, with_options


@click.command(epilog="Example: recon calibrate left right --board 9x6 --square 0.025")
@click.argument("left_dir", type=PATH)
@click.argument("right_dir", type=PATH)
@click.option("--board", required=True, metavar="CxR", help="Inner corners, as 9x6.")
@click.option("--square", required=True, type=PositiveNumber())
@click.option("-o", "--output", type=PATH, default=Path("calib.yaml"), show_default=True)
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@with_options(OUTPUT)
def calibrate(left_dir: Path, right_dir: Path, **given: Any) -> None:
    """Calibrate a rig from pairs of images of a chessboard.

    SQUARE is the side of a square in metres; it sets the unit of the baseline.
    """
    start_logging(given)
    from recon.runs.calibrate import calibrate_run

    report = calibrate_run(
        left_dir, right_dir, parse_board(given["board"]), given["square"], given["output"],
        overwrite=given["overwrite"],
    )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        click.echo(
            f"{report['num_pairs']} pairs, rms {report['rms_px']:.3f} px, "
            f"baseline {report['baseline']:.4f}: {report['output']}"
        )


def parse_board(text: str) -> tuple[int, int]:
    """Inner corners along a row and along a column, of "9x6"."""
    columns, _, rows = text.partition("x")
    if not (columns.isdecimal() and rows.isdecimal() and min(int(columns), int(rows)) >= 2):
        raise click.BadParameter(f"--board is {text!r}, but inner corners such as 9x6 are needed")
    return int(columns), int(rows)
