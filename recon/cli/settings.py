"""`recon settings`."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from recon.cli.options import REPORT, with_options
from recon.cli.output import print_document, start_logging
from recon.errors import InputError, unknown

if TYPE_CHECKING:
    from recon.settings.reference import Setting


@click.command(epilog="Example: recon settings map.cell_size")
@click.argument("name", required=False)
@with_options(REPORT)
def settings(name: str | None, **given: Any) -> None:
    """List all settings, or describe those of NAME, a setting or a stage."""
    start_logging(given)
    from recon.settings.reference import reference

    def is_meant(one: "Setting") -> bool:
        return name is None or one.name == name or one.name.startswith(f"{name}.")

    chosen = [one for one in reference() if is_meant(one)]
    if not chosen:
        names = [one.name for one in reference()]
        raise InputError(unknown(f"setting {name!r}", str(name), names))
    lines = (line for one in chosen for line in _lines(one))
    print_document(given, {"settings": [one.as_json() for one in chosen]}, lines)


def _lines(one: "Setting") -> Iterator[str]:
    """One setting for people."""
    differs = "" if one.thesis == one.default else f"   thesis: {_as_set(one.thesis)}"
    yield f"{one.name} = {_as_set(one.default)}   ({one.type}){differs}"
    yield f"    {one.meaning}"


def _as_set(value: Any) -> str:
    """A value in the form accepted by `--set`."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else json.dumps(value)
