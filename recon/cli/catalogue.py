"""`recon catalogue`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, with_options
from recon.cli.output import print_document, start_logging


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
    entries = [{"name": kind.name, "accepts": accepted(kind)} for kind in kinds]
    lines = [
        line
        for entry in entries
        for line in (entry["name"], *(f"    {one}" for one in entry["accepts"]))
    ]
    document = {"catalogue": str(Path(file)), "objects": entries}
    print_document(given, document, lines or ["no kinds: nothing is named"])
