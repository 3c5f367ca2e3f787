"""`recon calibrate`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, POSITIVE, with_options
from recon.cli.output import print_document, start_logging


@click.command(epilog="Example: recon calibrate left right --board 9x6 --square 0.025")
@click.argument("left_dir", type=PATH)
@click.argument("right_dir", type=PATH)
@click.option(
    "--board",
    required=True,
    metavar="CxR",
    help="Inner corners, such as 9x6, or charuco:CxR[:DICTIONARY][:MARKER], counted in squares.",
)
@click.option(
    "--square",
    required=True,
    type=POSITIVE,
    help="Side of a square in metres, which sets the unit of the baseline.",
)
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
    """Calibrate a rig from image pairs of a chessboard or a ChArUco board."""
    start_logging(given)
    from recon.runs.calibrate import calibrate_run

    report = calibrate_run(
        left_dir, right_dir, given["board"], given["square"], given["output"],
        overwrite=given["overwrite"], force=given["force"],
    )  # fmt: skip
    line = (
        f"{report['num_pairs']} pairs, rms {report['rms_px']:.3f} px, "
        f"baseline {report['baseline']:.4f}: {report['output']}"
    )
    print_document(given, report, [line])
