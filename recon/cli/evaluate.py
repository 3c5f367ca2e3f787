"""`recon evaluate`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recon.cli.jobs import do_job
from recon.cli.options import (
    KEEP,
    OUTPUT,
    PATH,
    POSITIVE,
    QUALITY,
    SETTINGS,
    TRUTH_SCALE,
    run_folder,
    with_options,
)
from recon.cli.output import say_numbers

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

TAKES: dict[str, set[str]] = {
    "surface": {"truth", "distances"},
    "trajectory": {"truth"},
    "worlds": set(),
    "dense": {"truth_scale"},
    "pairs": {"truth_scale", "matchers", "matching__keep"},
}
"""Options of each evaluation, besides those that all have."""
NOUNS = {
    "surface": "a surface", "trajectory": "a trajectory", "worlds": "worlds",
    "dense": "every pixel", "pairs": "pairs",
}  # fmt: skip
OPTIONS = {
    "truth": "--truth", "distances": "--distance", "truth_scale": "--truth-scale",
    "matchers": "--matcher", "matching__keep": "--keep",
}  # fmt: skip

DENSE_COLUMNS = {
    "covered": ".2f",
    "right": ".2f",
    "right_nonocc": ".2f",
    "wrong": ".2f",
    "median_px": ".3f",
    "within_1_sigma": ".1f",
    "within_2_sigma": ".1f",
    "seconds": ".2f",
}


@click.command(epilog="Example: recon evaluate data/motorcycle --matcher phase --matcher sgbm")
@click.argument("pair_dirs", nargs=-1, type=PATH)
@click.option("--dense", is_flag=True, help="Evaluate every pixel, beside OpenCV's matchers.")
@click.option("--surface", type=PATH, help="Evaluate the surface of a run; needs --truth.")
@click.option(
    "--distance",
    "distances",
    type=POSITIVE,
    multiple=True,
    help="Distance at which to evaluate a surface; repeatable.",
)
@click.option("--worlds", type=click.IntRange(min=1), help="Evaluate labels in N random worlds.")
@click.option("--matcher", "matchers", multiple=True, help="Matcher to evaluate; repeatable.")
@QUALITY
@KEEP
@TRUTH_SCALE
@click.option("--trajectory", type=PATH, help="Evaluate the trajectory of a run or of a pose file.")
@click.option(
    "--truth",
    type=PATH,
    help="True poses, or the true surface: a mesh, a cloud or a rendered recording.",
)
@with_options(SETTINGS, run_folder("none"), OUTPUT)
def evaluate(pair_dirs: tuple[Path, ...], **given: Any) -> None:
    """Evaluate matchers, labels in random worlds, a trajectory or a surface against truth.

    The search range is that of the settings, else of a pair's calibration, else slightly larger
    than that of its truth. -o leaves figures. ATE is the root mean square distance of positions
    after rigid alignment (Umeyama, no scale), RPE that of the steps from frame to frame.
    """
    kind = _kind(pair_dirs, given)
    if kind == "surface":
        asked: dict[str, Any] = {n: given[n] or None for n in ("surface", "truth", "distances")}
        do_job("surface", (), given, say=_say_surface, **asked)
    elif kind == "trajectory":
        path = (given["trajectory"],)
        do_job("trajectory", path, given, say=say_numbers, truth=given["truth"])
    elif kind == "worlds":
        do_job("worlds", (), given, say=_say_worlds, unit="worlds", worlds=given["worlds"])
    elif kind == "dense":
        do_job("dense", pair_dirs, given, say=_say_dense, truth_scale=given["truth_scale"])
    else:
        named = {name: given[name] for name in ("matchers", "truth_scale")}
        do_job("evaluate", pair_dirs, given, say=_say_pairs, **named)


def _kind(pair_dirs: tuple[Path, ...], given: dict[str, Any]) -> str:
    """The one evaluation requested; an option that belongs to another one is refused."""
    asked = [name for name in TAKES if given.get(name)] or ["pairs"]
    kind, takes = asked[0], TAKES[asked[0]]
    if len(asked) > 1:
        raise click.UsageError(f"--{asked[0]} and --{asked[1]} exclude each other")
    for name, option in OPTIONS.items():
        if given[name] and name not in takes:
            raise click.UsageError(f"{option} does not belong to the evaluation of {NOUNS[kind]}")
    if "truth" in takes and not given["truth"]:
        raise click.UsageError(f"--{kind} needs --truth FILE")
    if pair_dirs and "truth_scale" not in takes:
        raise click.UsageError(f"--{kind} and PAIR_DIRS exclude each other")
    if not pair_dirs and "truth_scale" in takes:
        others = "" if kind == "dense" else ", --worlds, --trajectory or --surface"
        raise click.UsageError(f"PAIR_DIRS{others} is needed")
    return kind


def _say_surface(report: "Report") -> None:
    click.echo(f"nine of ten points within {report['accuracy_90']:.4g} of the truth")
    for distance, value in report["fscore"].items():
        precision, recall = report["precision"][distance], report["recall"][distance]
        click.echo(
            f"at {distance:8}  precision {precision:.4f}  recall {recall:.4f}  F {value:.4f}"
        )


def _say_dense(report: "Report") -> None:
    click.echo(f"{'pair':14}{'matcher':10}" + "".join(f"{name:>15}" for name in DENSE_COLUMNS))
    for row in report["pairs"]:
        cells = ("-" if row[n] is None else f"{row[n]:{how}}" for n, how in DENSE_COLUMNS.items())
        click.echo(f"{row['name']:14}{row['matcher']:10}" + "".join(f"{c:>15}" for c in cells))


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
