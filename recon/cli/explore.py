"""`recon explore`."""

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
    run_order,
    start_logging,
    with_options,
)
from recon.cli.progress import progress_bar


@click.command(epilog="Example: recon explore scenes/village.scene -o runs/village")
@click.argument("scene", type=PATH)
@click.option(
    "--controller", "exploration__controller", help="frontier, thesis, or a plug-in's name."
)
@click.option("--recogniser", "recognition__recogniser", type=click.Choice(["robust", "thesis"]))
@click.option("--renderer", "render__renderer", type=click.Choice(["raycast", "filament"]))
@click.option("--max-pairs", "exploration__max_pairs", type=click.IntRange(min=1))
@with_options(MATCHING, SETTINGS, FOLDER, OUTPUT)
def explore(scene: Path, **given: Any) -> None:
    """Explore a simulated world: map it, name its objects."""
    start_logging(given)
    from recon.runs.explore import BASE, BASE_QUALITY, explore_run

    base = BASE | {"render.noise_seed": given["seed"]}
    settings = build_settings(given, base, BASE_QUALITY)
    with progress_bar("pairs", given["quiet"]) as progress:
        report = explore_run(scene, settings, run_order(given, scene.stem, progress))
    if given["as_json"]:
        print_json(report)
    elif not given["quiet"]:
        _say(report)
    if report["stop_reason"] == "interrupted":
        raise click.Abort


def _say(report: dict[str, Any]) -> None:
    for found in report["objects"]:
        x, _, z = found["centre"]
        click.echo(f"{found['label']:12} at x {x:7.2f}, z {z:7.2f}   {found['probability']:.0%}")
    click.echo(
        f"{report['num_pairs']} pairs, {report['num_points']} points, "
        f"{report['coverage']:.0%} of the floor known; stopped: {report['stop_reason']}"
    )
    click.echo(report["run"])
