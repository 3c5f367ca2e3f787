"""`recon reconstruct`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    FOLDER,
    MATCHING,
    OUTPUT,
    PATH,
    SETTINGS,
    build_settings,
    print_json,
    start_logging,
    with_options,
)
from recon.cli.progress import progress_bar

FORMATS = ["auto", "folder", "kitti", "euroc", "middlebury", "ring", "video", "bag"]


@click.command(epilog="Example: recon reconstruct data/motorcycle -o runs/motorcycle")
@click.argument("sequence", type=PATH)
@click.option("--format", "format_", type=click.Choice(FORMATS))
@click.option("--poses", type=click.Choice(["given", "estimated", "none"]))
@click.option("--every", type=click.IntRange(min=1), help="Read every Nth pair.")
@with_options(MATCHING, SETTINGS, FOLDER, OUTPUT)
def reconstruct(sequence: Path, **given: Any) -> None:
    """Reconstruct what a calibrated stereo recording saw."""
    start_logging(given["quiet"], given["verbose"])
    from recon.runs.reconstruct import base_values, reconstruct_run

    settings = build_settings(
        preset=given["preset"],
        settings_file=given["settings_file"],
        overrides=given["overrides"],
        quality=given["quality"],
        base=base_values(sequence, given["format_"] or "auto"),
        flags={
            "sequence.format": given["format_"],
            "sequence.poses": given["poses"],
            "sequence.every": given["every"],
            "matching.matcher": given["matcher"],
            "matching.keep": given["keep"],
        },
    )
    run_path = given["output"] or Path("runs") / sequence.resolve().name
    with progress_bar("pairs", given["quiet"]) as progress:
        report = reconstruct_run(
            sequence, run_path, settings, seed=given["seed"], overwrite=given["overwrite"],
            resume=given["resume"], progress=progress,
        )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        click.echo(
            f"{report['num_pairs']} pairs, {report['num_points']} points, "
            f"{report['num_voxels']} occupied cells"
        )
        click.echo(report["run"])
