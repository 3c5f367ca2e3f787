"""`recon settings`."""

import json
from typing import Any

import click

from recon.cli.options import OUTPUT, print_json, start_logging, with_options
from recon.errors import InputError, unknown


@click.command(epilog="Example: recon settings map.cell_size")
@click.argument("name", required=False)
@with_options(OUTPUT)
def settings(name: str | None, as_json: bool, quiet: bool, verbose: bool) -> None:
    """List all settings, or describe those of NAME, a setting or a stage."""
    start_logging({"quiet": quiet, "verbose": verbose})
    from recon.settings.reference import Setting, reference

    def is_meant(one: Setting) -> bool:
        return name is None or one.name == name or one.name.startswith(f"{name}.")

    chosen = [one for one in reference() if is_meant(one)]
    if not chosen:
        names = [one.name for one in reference()]
        raise InputError(unknown(f"setting {name!r}", str(name), names))
    if as_json:
        print_json({"settings": [one.as_json() for one in chosen]})
    elif not quiet:
        for one in chosen:
            differs = "" if one.thesis == one.default else f"   thesis: {_as_set(one.thesis)}"
            click.echo(f"{one.name} = {_as_set(one.default)}   ({one.type}){differs}")
            click.echo(f"    {one.meaning}")


def _as_set(value: Any) -> str:
    """A value in the form accepted by `--set`."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else json.dumps(value)
