"""`recon fetch`."""

from pathlib import Path

import click

from recon.cli.options import OUTPUT, PATH, print_json, start_logging, with_options


@click.command(epilog="Example: recon fetch motorcycle -o data/motorcycle")
@click.argument("name")
@click.option("-o", "--output", type=PATH, help="Output folder, NAME by default.")
@with_options(OUTPUT)
def fetch(name: str, output: Path | None, as_json: bool, quiet: bool, verbose: bool) -> None:
    """Unpack a sample recording, such as motorcycle, from an installed package."""
    start_logging({"quiet": quiet, "verbose": verbose})
    from recon.sequences.samples import fetch as unpack

    files = unpack(name, output or Path(name))
    if as_json:
        print_json({"files": [str(path) for path in files]})
    elif not quiet:
        click.echo(f"{files[0].parent}: {', '.join(path.name for path in files)}")
