"""`recon catalogue`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, print_json, start_logging, with_options


@click.group()
def catalogue() -> None:
    """Catalogues of kinds of objects."""


@catalogue.command(epilog="Example: recon catalogue check household")
@click.argument("file")
@with_options(OUTPUT)
def check(file: str, **given: Any) -> None:
    """Check a catalogue, and show what each of its entries accepts."""
    start_logging(given)
    from recon.recognition.naming.acceptance import accepted
    from recon.recognition.naming.catalogue import read_catalogues

    kinds = read_catalogues([file])
    if given["as_json"]:
        entries = [{"name": kind.name, "accepts": accepted(kind)} for kind in kinds]
        print_json({"catalogue": str(Path(file)), "objects": entries})
    elif not given["quiet"]:
        if not kinds:
            click.echo("no kinds: nothing is named")
        for kind in kinds:
            click.echo(kind.name)
            for line in accepted(kind):
                click.echo(f"    {line}")
