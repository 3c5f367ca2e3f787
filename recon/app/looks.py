"""Display options of a layer, and names of its columns and objects."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.records import UNKNOWN, FoundObject

COLOUR = "colour"
LENGTHS = {"x", "y", "z", "sigma", "depth", "height"}
"""Columns that are lengths."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """Display options of a layer."""

    colour_by: str = COLOUR
    is_dark: bool = True
    is_quick: bool = False
    """True for a coarse image of half the resolution, while the view turns."""
    unit: str = ""
    """Unit of lengths, if known."""
    selected: int | None = None
    """Id of the highlighted object."""
    solids: tuple[FoundObject, ...] = ()
    """Objects whose solids are drawn over the cells."""


def with_unit(name: str, unit: str) -> str:
    """A column's name with the unit of its values, if known."""
    return f"{name} [{unit}]" if unit and name in LENGTHS else name


def name_of(found: FoundObject) -> str:
    """The label of an object; its id, as in the table, if it has none."""
    return f"#{found.id}" if found.label == UNKNOWN else found.label


def top_of(found: FoundObject) -> NDArray[np.float64]:
    """The middle (3,) of an object's top; of its cells, if their box is known."""
    box = found.box
    middle, height = (found.centre, found.size[1]) if box is None else (box.centre, box.sizes[1])
    top = np.array(middle, np.float64)
    top[1] += 0.5 * height
    return top
