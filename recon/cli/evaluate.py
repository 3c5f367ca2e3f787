"""`recon evaluate`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import (
    FOLDER,
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
from recon.cli.progress import progress_bar

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
@click.option("--matcher", "matchers", multiple=True, default=["phase"], help="May be repeated.")
@click.option("--quality", type=click.Choice(["best", "fast"]))
@click.option(
    "--keep", "matching__keep", type=click.IntRange(min=1), help="Keep the K most confident pairs."
)
@click.option("--truth-scale", type=PositiveNumber())
@with_options(SETTINGS, FOLDER, OUTPUT)
def evaluate(pair_dirs: tuple[Path, ...], **given: Any) -> None:
    """Judge matchers on pairs whose disparity is known, or labels in random worlds.

    -o leaves figures.
    """
    start_logging(given)
    if bool(pair_dirs) == bool(given["worlds"]):
        raise click.UsageError("PAIR_DIRS or --worlds N is needed, and not both")
    if given["worlds"]:
        _evaluate_worlds(given)
    else:
        _evaluate_pairs(pair_dirs, given)


def _evaluate_worlds(given: dict[str, Any]) -> None:
    from recon.runs.explore import BASE, BASE_QUALITY
    from recon.runs.worlds import worlds_run

    settings = build_settings(given, BASE, BASE_QUALITY)
    with progress_bar("worlds", given["quiet"]) as progress:
        report = worlds_run(
            given["worlds"], settings, seed=given["seed"],
            order=run_order(given, "worlds", progress) if given["output"] else None,
            progress=progress,
        )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        for name in ("robust", "thesis"):
            counts = report[name]
            click.echo(
                f"{name:8} {counts['num_right']} of {counts['num_objects']} labels right, "
                f"{counts['success']:.1f} %"
            )


def _evaluate_pairs(pair_dirs: tuple[Path, ...], given: dict[str, Any]) -> None:
    from recon.runs.evaluate import evaluate_run

    settings = build_settings(given)
    with progress_bar("pairs", given["quiet"]) as progress:
        report = evaluate_run(
            pair_dirs, settings, given["matchers"], truth_scale=given["truth_scale"],
            order=run_order(given, "evaluation", progress) if given["output"] else None,
            progress=progress,
        )  # fmt: skip
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        _print_table(report["pairs"])


def _print_table(rows: list[dict[str, Any]]) -> None:
    click.echo(f"{'pair':14}{'matcher':10}" + "".join(f"{name:>19}" for name in COLUMNS))
    for row in rows:
        cells = (
            "-" if row[name] is None else f"{row[name]:{how}}" for name, how in COLUMNS.items()
        )
        click.echo(f"{row['name']:14}{row['matcher']:10}" + "".join(f"{c:>19}" for c in cells))
