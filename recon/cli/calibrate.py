"""`recon calibrate`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, POSITIVE, print_json, start_logging, with_options


@click.command(epilog="Example: recon calibrate left right --board 9x6 --square 0.025")
@click.argument("left_dir", type=PATH)
@click.argument("right_dir", type=PATH)
@click.option(
    "--board",
    required=True,
    metavar="CxR",
    help="Inner corners, such as 9x6, or charuco:CxR[:DICTIONARY][:MARKER], counted in squares.",
)
@click.option("--square", required=True, type=POSITIVE, help="Side of a square in metres.")
@click.option(
    "-o", "--output", type=PATH, default=Path("calib.yaml"), show_default=True,
    help="File to write.",
)  # fmt: skip
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@click.option(
    "--force", is_flag=True, help="Write a calibration even if its rms exceeds one pixel."
)
@with_options(OUTPUT)
def calibrate(left_dir: Path, right_dir: Path, **given: Any) -> None:
    """Calibrate a rig from image pairs of a chessboard or a ChArUco board.

    SQUARE is the side of a square in metres; it sets the unit of the baseline.
    """
    start_logging(given)
    from recon.runs.calibrate import calibrate_run

    report = calibrate_run(
        left_dir, right_dir, given["board"], given["square"], given["output"],
        overwrite=given["overwrite"], force=given["force"],
    )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        click.echo(
            f"{report['num_pairs']} pairs, rms {report['rms_px']:.3f} px, "
            f"baseline {report['baseline']:.4f}: {report['output']}"
        )
