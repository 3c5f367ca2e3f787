"""Objects by parts (thesis figures 28, 29): the cells by hue, then every part separately."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from recon.figures.canvas import Sheet, Size
from recon.figures.map3d import UNITS, Standpoint, map3d
from recon.figures.partition import PartCells, by_hue
from recon.records import UNKNOWN, FoundObject, Voxels

SIZE: Size = (1200, 1050)
MAX_ROWS = 5
"""Maximum number of kinds on one sheet."""


def parts(
    voxels: Voxels,
    objects: Sequence[FoundObject],
    *,
    unit: str = UNITS,
    sheet: Sheet | None = None,
) -> Any:
    """One row for the largest object of every label: its hues, then its parts."""
    sheet = sheet or Sheet.of(SIZE)
    chosen = largest_of_each(objects)[:MAX_ROWS]
    columns = 1 + max((len(found.parts) for found in chosen), default=0)
    if not chosen:
        sheet.axes("No object with a name was found").set_axis_off()
        return sheet.figure
    standpoint = Standpoint(unit=unit)
    panels = sheet.panels(len(chosen), columns)
    for row, found in enumerate(chosen):
        cells = PartCells.of(voxels, found)
        coloured = replace(cells.cells, colours=by_hue(cells.cells))
        map3d(
            coloured,
            standpoint=standpoint,
            title=f"{found.label}: hue",
            with_numbers=False,
            sheet=panels[row, 0],
        )
        for number, part in enumerate(found.parts):
            map3d(
                cells.own(number),
                standpoint=standpoint,
                title=f"{part.role}: {part.solid.kind}",
                with_numbers=False,
                sheet=panels[row, 1 + number],
            )
    return sheet.figure


def largest_of_each(objects: Sequence[FoundObject]) -> list[FoundObject]:
    """For every label, by name, the object with the most cells."""
    named = sorted(objects, key=lambda found: (found.label, found.num_voxels))
    return list({found.label: found for found in named if found.label != UNKNOWN}.values())
