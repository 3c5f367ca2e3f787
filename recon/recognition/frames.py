"""Solids, cells, objects and planes in another frame."""

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.geometry import transform
from recon.records import BoundingBox, FoundObject, FoundPlane, Part, Solid, Voxels

Array = NDArray[np.float64]
Placed = TypeVar("Placed", bound=Solid | BoundingBox | FoundPlane)

POINTS = ("centre", "point", "apex")
DIRECTIONS = ("axis", "normal", "axes")


def moved(one: Placed, T_target_source: Array) -> Placed:
    """The same solid, box or plane in another frame."""
    changes: dict[str, Any] = {}
    for field in fields(one):
        value = getattr(one, field.name)
        if field.name in POINTS:
            changes[field.name] = transform(T_target_source, value[None])[0]
        elif field.name in DIRECTIONS:
            changes[field.name] = value @ T_target_source[:3, :3].T
    return replace(one, **changes)


def moved_cells(voxels: Voxels, T_target_source: Array) -> Voxels:
    """Cells with positions in another frame; their indices, and so their neighbours, stay."""
    return replace(
        voxels,
        means=transform(T_target_source, voxels.means),
        centres=transform(T_target_source, voxels.centres),
    )


def moved_object(found: FoundObject, T_target_source: Array) -> FoundObject:
    """The same object in another frame; its `size` stays along the axes of the old frame."""
    explaining = found.solid
    return replace(
        found,
        centre=transform(T_target_source, found.centre[None])[0],
        parts=tuple(_moved_part(part, T_target_source) for part in found.parts),
        box=found.box and moved(found.box, T_target_source),
        solid=explaining and replace(explaining, solid=moved(explaining.solid, T_target_source)),
    )


def _moved_part(part: Part, T_target_source: Array) -> Part:
    return replace(part, solid=moved(part.solid, T_target_source))
