"""`recon inspect`."""

from pathlib import Path
from typing import Any

import click

from recon.cli.options import OUTPUT, PATH, with_options
from recon.cli.output import start_logging
from recon.cli.pages import SERVER, announced


@click.command(epilog="Example: recon inspect runs/village")
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="RUN|FILE...")
@with_options(SERVER, OUTPUT)
def inspect(paths: tuple[Path, ...], **given: Any) -> None:
    """View runs, maps, clouds and meshes in a browser, two of them side by side."""
    start_logging(given)
    from recon.app.inspector import inspect as show
    from recon.app.serving import listen

    address = listen(given["host"], given["port"])
    show(paths, address, announced(address.url, given))
