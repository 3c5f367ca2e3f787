"""The inspector: maps, clouds, meshes and runs, looked at from all sides."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from recon.app.exhibit import Exhibit, open_exhibit
from recon.app.exhibit_page import ExhibitPage
from recon.app.serving import Address, serve
from recon.app.widgets import header, nicegui
from recon.errors import InputError

MOST_SHOWN = 2
"""Side by side."""


def inspect(paths: Sequence[Path], address: Address, announce: Any) -> None:
    """Show files and runs in a browser until Ctrl-C.

    Raises
    ------
    InputError
        Where one of them cannot be shown.
    """
    if len(paths) > MOST_SHOWN:
        raise InputError(f"{len(paths)} things to inspect, but {MOST_SHOWN} fit side by side")
    exhibits = [open_exhibit(path) for path in paths]
    title = " | ".join(exhibit.path.name for exhibit in exhibits)
    serve(lambda: build(exhibits), address, f"recon inspect {title}", announce)


def build(exhibits: Sequence[Exhibit]) -> None:
    """Fill the page of one visitor."""
    ui = nicegui()
    dark = header("recon inspect", "   ".join(exhibit.path.name for exhibit in exhibits))
    pages = []
    with ui.element("div").classes("recon-page"):
        for number, exhibit in enumerate(exhibits, start=1):
            suffix = "" if number == 1 else f"-{number}"
            pages.append(ExhibitPage(exhibit, suffix, is_alone=len(exhibits) == 1))
    for page in pages:
        page.panel.followers = [other.panel for other in pages if other is not page]

    def change(event: Any) -> None:
        for page in pages:
            page.set_dark(is_dark=bool(event.value))

    dark.on_value_change(change)
