"""`recon disparity`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    MATCHING,
    OUTPUT,
    PATH,
    SETTINGS,
    build_settings,
    print_json,
    start_logging,
    with_options,
)


@click.command(epilog="Example: recon disparity left.png right.png --max-disparity 64 -o out")
@click.argument("left", type=PATH)
@click.argument("right", type=PATH)
@click.option("--min-disparity", type=int)
@click.option("--max-disparity", type=int)
@click.option("--truth", type=PATH, help="Disparity image of the left view; 0 or NaN = unknown.")
@click.option("--truth-scale", type=click.FloatRange(min=0, min_open=True), default=1.0)
@click.option("--calib", type=PATH, help="Calibration; its search range is the default.")
@click.option("-o", "--output", type=PATH, help="Folder for matches.npz and disparity.png.")
@with_options(MATCHING, SETTINGS, OUTPUT)
def disparity(left: Path, right: Path, **given: Any) -> None:
    """Match two rectified images."""
    start_logging(given["quiet"], given["verbose"])
    from recon.runs.disparity import disparity_run, search_range

    settings = build_settings(
        preset=given["preset"],
        settings_file=given["settings_file"],
        overrides=given["overrides"],
        quality=given["quality"],
        base=search_range(given["calib"]) if given["calib"] else {},
        flags={
            "matching.min_disparity": given["min_disparity"],
            "matching.max_disparity": given["max_disparity"],
            "matching.matcher": given["matcher"],
            "matching.keep": given["keep"],
        },
    )
    report = disparity_run(
        left, right, settings, output=given["output"], truth_path=given["truth"],
        truth_scale=given["truth_scale"],
    )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        for name, value in report.items():
            click.echo(f"{name:20} {value}")
