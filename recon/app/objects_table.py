"""The objects of a run as a table whose selection is linked with the scene."""

from collections.abc import Callable, Sequence
from typing import Any

from recon.app.widgets import nicegui, note, testid
from recon.records import FoundObject

COLUMNS = ("id", "label", "probability", "x", "z", "height", "views")
WHILE_EXPLORED = COLUMNS[:-1]
"""Columns that are known before a run ends."""


def rows_of(objects: tuple[FoundObject, ...]) -> list[dict[str, Any]]:
    """One table row per object."""
    return [
        {
            "id": found.id,
            "label": found.label,
            "probability": "" if found.probability is None else f"{found.probability:.0%}",
            "x": f"{found.centre[0]:.2f}",
            "z": f"{found.centre[2]:.2f}",
            "height": f"{found.size[1]:.2f}",
            "views": found.views,
        }
        for found in objects
    ]


class ObjectsTable:
    """A table of objects; a click selects one, a second click deselects it."""

    def __init__(
        self,
        name: str,
        objects: tuple[FoundObject, ...],
        chosen: Callable[[int | None], Any],
        columns: Sequence[str] = COLUMNS,
    ) -> None:
        ui = nicegui()
        heads = [{"name": one, "label": one, "field": one, "align": "left"} for one in columns]
        with testid(ui.element("div").classes("w-full"), name):
            self.table = ui.table(
                rows=rows_of(objects), columns=heads, row_key="id", selection="single"
            )
            self.table.props("dense flat hide-bottom :rows-per-page-options=[0]")
            self.table.classes("w-full")
            self.lack = note(words="nothing is found yet" if columns != COLUMNS else "none")
            self.lack.set_visibility(not objects)
        self._chosen = chosen
        self.table.on("rowClick", lambda event: self._click(event.args[1]["id"]))
        self.table.on_select(lambda event: self._tell())

    def show(self, objects: tuple[FoundObject, ...]) -> None:
        """Show other objects."""
        self.table.rows = rows_of(objects)
        self.table.update()
        self.lack.set_visibility(not objects)

    def select(self, number: int) -> None:
        """Select the row of an object."""
        self.table.selected = [row for row in self.table.rows if row["id"] == number]
        self.table.update()
        self._tell()

    def _click(self, number: int) -> None:
        if [row["id"] for row in self.table.selected] == [number]:
            self.table.selected = []
            self.table.update()
            self._tell()
        else:
            self.select(number)

    def _tell(self) -> None:
        selected = self.table.selected
        self._chosen(selected[0]["id"] if selected else None)
