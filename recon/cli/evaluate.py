"""`recon evaluate`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import do_job
from recon.cli.options import (
    FOLDER,
    OUTPUT,
    PATH,
    SETTINGS,
    PositiveNumber,
    with_options,
)

if TYPE_CHECKING:
    from recon.runs.report import Report

COLUMNS = {
    "num_matches": "d",
    "num_mismatches": "d",
    "success_all": ".2f",
    "success_nonocc": ".2f",
    "rms_px": ".3f",
    "bad_share": ".4f",
    "subpixel_median_px": ".3f",
    "subpixel_rms_px": ".3f",
    "coverage": ".2f",
    "seconds": ".2f",
}


@click.command(epilog="Example: recon evaluate data/motorcycle --matcher phase --matcher sgbm")
@click.argument("pair_dirs", nargs=-1, type=PATH)
@click.option("--worlds", type=click.IntRange(min=1), help="Judge labels in N random worlds.")
@click.option("--matcher", "matchers", multiple=True, help="May be repeated.")
@click.option("--quality", type=click.Choice(["best", "fast"]))
@click.option(
    "--keep", "matching__keep", type=click.IntRange(min=1), help="Keep the K most confident pairs."
)
@click.option("--truth-scale", type=PositiveNumber())
@click.option("--trajectory", type=PATH, help="Judge the path of a run, or of a file of poses.")
@click.option("--truth", type=PATH, help="The true poses of that path.")
@with_options(SETTINGS, FOLDER, OUTPUT)
def evaluate(pair_dirs: tuple[Path, ...], **given: Any) -> None:
    """Judge matchers on pairs whose disparity is known, labels in random worlds, or a path.

    -o leaves figures. ATE is the root mean square distance of positions after rigid alignment
    (Umeyama, no scale), RPE that of the steps from frame to frame.
    """
    if given["trajectory"] or given["truth"]:
        if not (given["trajectory"] and given["truth"]) or pair_dirs or given["worlds"]:
            raise click.UsageError("--trajectory RUN and --truth FILE are needed, and nothing else")
        path = (given["trajectory"],)
        do_job("trajectory", path, given, say=_say_numbers, truth=given["truth"])
        return
    if bool(pair_dirs) == bool(given["worlds"]):
        raise click.UsageError("PAIR_DIRS or --worlds N is needed, and not both")
    if given["worlds"]:
        do_job("worlds", (), given, say=_say_worlds, unit="worlds", worlds=given["worlds"])
    else:
        named = {name: given[name] for name in ("matchers", "truth_scale")}
        do_job("evaluate", pair_dirs, given, say=_say_pairs, **named)


def _say_numbers(report: "Report") -> None:
    for name, value in report.numbers.items():
        click.echo(f"{name:24} {value}")


def _say_worlds(report: "Report") -> None:
    for name in ("robust", "thesis"):
        counts = report[name]
        click.echo(
            f"{name:8} {counts['num_right']} of {counts['num_objects']} labels right, "
            f"{counts['success']:.1f} %"
        )


def _say_pairs(report: "Report") -> None:
    click.echo(f"{'pair':14}{'matcher':10}" + "".join(f"{name:>19}" for name in COLUMNS))
    for row in report["pairs"]:
        cells = (
            "-" if row[name] is None else f"{row[name]:{how}}" for name, how in COLUMNS.items()
        )
        click.echo(f"{row['name']:14}{row['matcher']:10}" + "".join(f"{c:>19}" for c in cells))
