"""`recon disparity`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.jobs import do_job
from recon.cli.options import (
    MATCHING,
    OUTPUT,
    PATH,
    SETTINGS,
    TRUTH_SCALE,
    run_folder,
    with_options,
)
from recon.cli.output import say_numbers


@click.command(epilog="Example: recon disparity left.png right.png --max-disparity 64 -o out")
@click.argument("left", type=PATH)
@click.argument("right", type=PATH)
@click.option(
    "--min-disparity", "matching__min_disparity", type=int, help="Smallest disparity, pixels."
)
@click.option(
    "--max-disparity", "matching__max_disparity", type=int, help="Largest disparity, pixels."
)
@click.option("--truth", type=PATH, help="True disparity of the left image; 0 or NaN = unknown.")
@TRUTH_SCALE
@click.option("--calib", type=PATH, help="Calibration; gives the default search range.")
@click.option(
    "--dense",
    "dense__enabled",
    is_flag=True,
    default=None,
    help="Match every pixel as well, and save dense.pfm and dense_sigma.pfm.",
)
@with_options(MATCHING, SETTINGS, run_folder("none"), OUTPUT)
def disparity(left: Path, right: Path, **given: Any) -> None:
    """Match two rectified images; with -o, save matches.npz and figures."""
    named = {name: given[name] for name in ("truth", "truth_scale", "calib")}
    do_job("disparity", (left, right), given, say=say_numbers, **named)
