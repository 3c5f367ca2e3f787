"""`recon fetch`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, with_options
from recon.cli.output import print_document, start_logging


@click.command(epilog="Example: recon fetch motorcycle -o data/motorcycle")
@click.argument("name")
@click.option("-o", "--output", type=PATH, help="Output folder, NAME by default.")
@with_options(OUTPUT)
def fetch(name: str, output: Path | None, **given: Any) -> None:
    """Unpack a sample recording, such as motorcycle, from an installed package."""
    start_logging(given)
    from recon.sequences.samples import fetch as unpack

    files = unpack(name, output or Path(name))
    line = f"{files[0].parent}: {', '.join(path.name for path in files)}"
    print_document(given, {"files": [str(path) for path in files]}, [line])
