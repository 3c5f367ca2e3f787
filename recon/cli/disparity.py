"""`recon disparity`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    FOLDER,
    MATCHING,
    OUTPUT,
    PATH,
    SETTINGS,
    PositiveNumber,
    build_settings,
    print_json,
    run_order,
    start_logging,
    with_options,
)


@click.command(epilog="Example: recon disparity left.png right.png --max-disparity 64 -o out")
@click.argument("left", type=PATH)
@click.argument("right", type=PATH)
@click.option("--min-disparity", "matching__min_disparity", type=int)
@click.option("--max-disparity", "matching__max_disparity", type=int)
@click.option("--truth", type=PATH, help="Disparity image of the left view; 0 or NaN = unknown.")
@click.option("--truth-scale", type=PositiveNumber())
@click.option("--calib", type=PATH, help="Calibration; its search range is the default.")
@click.option(
    "--dense",
    "dense__enabled",
    is_flag=True,
    default=None,
    help="A disparity for every pixel that the images support, too: dense.pfm.",
)
@with_options(MATCHING, SETTINGS, FOLDER, OUTPUT)
def disparity(left: Path, right: Path, **given: Any) -> None:
    """Match two rectified images; -o leaves matches.npz and figures."""
    start_logging(given)
    from recon.runs.disparity import disparity_run, search_range
    from recon.runs.order import unwatched

    settings = build_settings(given, search_range(given["calib"]) if given["calib"] else {})
    report = disparity_run(
        left, right, settings,
        order=run_order(given, "disparity", unwatched) if given["output"] else None,
        truth_path=given["truth"], truth_scale=given["truth_scale"],
    )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        for name, value in report.items():
            click.echo(f"{name:20} {value}")
