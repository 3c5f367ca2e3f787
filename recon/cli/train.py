"""`recon train`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.jobs import counted
from recon.cli.options import OUTPUT, PATH, SETTINGS, build_settings, with_options
from recon.cli.output import print_document, start_logging


@click.command(epilog="Example: recon train data/motorcycle -o model.json")
@click.argument("pair_dirs", nargs=-1, required=True, type=PATH)
@click.option("-o", "--output", required=True, type=PATH, help="Model file to write.")
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True,
    help="Seed of all random numbers.",
)  # fmt: skip
@with_options(SETTINGS, OUTPUT)
def train(pair_dirs: tuple[Path, ...], **given: Any) -> None:
    """Train the model of the von Mises matcher on pairs; no ground truth is needed.

    Use it with --matcher vonmises --set matching.model=FILE.
    """
    start_logging(given)
    from recon.runs.train import train_run

    settings = build_settings(given)
    report = train_run(
        pair_dirs, settings, given["output"], seed=given["seed"], overwrite=given["overwrite"]
    )
    pairs = counted(report["num_pairs"], "pair")
    line = f"{report['num_matches']} matches of {pairs}: {report['output']}"
    print_document(given, report, [line])
