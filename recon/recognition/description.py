"""The description of every object, named or not."""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming.visibility import coverage
from recon.recognition.segments.boxes import upright_box
from recon.records import BoundingBox, ExplainingSolid, FoundObject, Plane, Solid, Voxels

Array = NDArray[np.float64]

ON_SOLID_CELLS = 0.75
"""A cell within this share of the cell size is on a solid."""


def described(
    found: FoundObject, solid: Solid | None, cells: Voxels, unit: Literal["m"] | None
) -> FoundObject:
    """The object with its box, colour, best solid and visible share.

    Parameters
    ----------
    solid : Solid, optional
        The single solid that fits its cells best.
    cells : Voxels
        The cells of the object, in its frame.
    """
    seen = found.seen
    if seen is None and solid is not None and not isinstance(solid, Plane):
        seen = float(coverage([solid], cells)[0])
    return replace(
        found,
        box=bounding_box(cells, unit),
        colour=dominant_colour(cells),
        solid=None if solid is None else explaining(solid, cells),
        seen=None if seen is None else round(seen, 6),
    )


def bounding_box(cells: Voxels, unit: Literal["m"] | None) -> BoundingBox:
    """The upright box of the cells' means."""
    box = upright_box(cells.means)
    return BoundingBox(centre=box.centre, axes=box.axes, sizes=box.sizes, unit=unit)


def explaining(solid: Solid, cells: Voxels) -> ExplainingSolid:
    """A solid with the share of the cells on it."""
    on_it = solid.distances(cells.means) < ON_SOLID_CELLS * cells.cell_size
    return ExplainingSolid(solid=solid, explained=float(on_it.mean()))


def dominant_colour(cells: Voxels) -> tuple[int, int, int] | None:
    """The typical colour of the cells: their median per channel; None if they have none."""
    if cells.colours is None:
        return None
    red, green, blue = np.median(cells.colours, axis=0).astype(int).tolist()
    return red, green, blue
