"""The inspector: interactive views of maps, clouds, meshes and runs in a browser."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from recon.app.exhibit import open_exhibit
from recon.app.serving import Address, serve
from recon.errors import InputError

MOST_SHOWN = 2
"""Maximum number of exhibits side by side."""


def inspect(paths: Sequence[Path], address: Address, announce: Any) -> None:
    """Show files and runs in a browser until Ctrl-C.

    Raises
    ------
    InputError
        If one of them cannot be shown.
    """
    if len(paths) > MOST_SHOWN:
        raise InputError(f"{len(paths)} paths to inspect, but {MOST_SHOWN} fit side by side")
    exhibits = [open_exhibit(path) for path in paths]
    title = " | ".join(exhibit.path.name for exhibit in exhibits)

    def build() -> None:
        # Late: the browser starts meanwhile.
        from recon.app.inspector_page import build

        build(exhibits)

    serve(build, address, f"recon inspect {title}", announce)
