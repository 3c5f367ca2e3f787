"""`recon info`."""

from pathlib import Path

import click

from recon.cli.options import OUTPUT, PATH, print_json, start_logging, with_options


@click.command(epilog="Example: recon info runs/village")
@click.argument("file", type=PATH)
@with_options(OUTPUT)
def info(file: Path, as_json: bool, quiet: bool, verbose: bool) -> None:
    """Say what a run folder, map, cloud, scene, sequence or image is."""
    start_logging({"quiet": quiet, "verbose": verbose})
    from recon.runs.info import describe

    facts = describe(file)
    if as_json:
        print_json(facts)
    elif not quiet:
        for name, value in facts.items():
            click.echo(f"{name:16} {value}")
