"""`recon rectify`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.jobs import counted
from recon.cli.options import OUTPUT, PATH, with_options
from recon.cli.output import print_document, start_logging


@click.command(epilog="Example: recon rectify left right --calib calib.yaml -o rectified")
@click.argument("left", type=PATH)
@click.argument("right", type=PATH)
@click.option("--calib", type=PATH, required=True, help="Calibration of the raw cameras.")
@click.option(
    "-o", "--output", type=PATH, required=True, help="Output folder for the images and calib.txt."
)
@click.option("--overwrite", is_flag=True, help="Write into an existing folder.")
@with_options(OUTPUT)
def rectify(left: Path, right: Path, **given: Any) -> None:
    """Rectify two images or two folders of images, and save their calibration."""
    start_logging(given)
    from recon.runs.calibrate import rectify_run

    report = rectify_run(left, right, given["calib"], given["output"], overwrite=given["overwrite"])
    line = (
        f"{counted(report['num_pairs'], 'pair')}, focal length {report['focal_px']:.2f} px, "
        f"baseline {report['baseline']:.4f}: {report['output']}"
    )
    print_document(given, report, [line])
