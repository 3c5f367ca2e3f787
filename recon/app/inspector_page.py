"""The inspector's page: one exhibit, or two side by side."""

from collections.abc import Sequence
from typing import Any

from recon.app.exhibit import Exhibit
from recon.app.exhibit_page import ExhibitPage
from recon.app.widgets import header, nicegui


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
