"""What was recognised."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records.solids import Solid, from_parameters, parameters

UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """One solid of an object."""

    role: str
    """"crown", "body", ..., as the catalogue names it."""
    solid: Solid
    hue_deg: float | None
    """None where the part is grey or of many colours."""
    num_voxels: int
    rms: float
    """Root mean square distance of the part's cells to the solid, world units."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundObject:
    """One object with its label; world coordinates and units."""

    id: int
    label: str
    """A name of the catalogue, or "unknown"."""
    probability: float
    """Of the label, 0 to 1."""
    centre: NDArray[np.float64]
    """(3,) x, z on the fitted vertical axis, y halfway between the ground and the top; of an
    unknown, the middle of the box of its cell means."""
    size: NDArray[np.float64]
    """(3,) extent of the solids along the axes, from the ground up."""
    num_voxels: int
    views: int = 0
    """Number of pairs that put at least 10 points on it."""
    parts: tuple[Part, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recognition:
    """All objects of a map, and what could not be fitted."""

    objects: tuple[FoundObject, ...]
    label: NDArray[np.int32]
    """(K,) id of the object of each cell that was handed in; -1 = ground or none."""
    failures: dict[str, int] = field(default_factory=dict)
    """How often a fit failed, by reason."""


def as_json(recognition: Recognition) -> dict[str, object]:
    """The document of `objects.json`."""
    return {
        "objects": [_object_json(found) for found in recognition.objects],
        "failures": dict(sorted(recognition.failures.items())),
    }


def _object_json(found: FoundObject) -> dict[str, object]:
    return {
        "id": found.id,
        "label": found.label,
        "probability": round(found.probability, 6),
        "centre": found.centre.tolist(),
        "size": found.size.tolist(),
        "num_voxels": found.num_voxels,
        "views": found.views,
        "parts": [
            {
                "role": part.role,
                "shape": part.solid.kind,
                "parameters": parameters(part.solid),
                "hue_deg": part.hue_deg,
                "num_voxels": part.num_voxels,
                "rms": part.rms,
            }
            for part in found.parts
        ],
    }


def from_json(document: dict[str, Any]) -> tuple[FoundObject, ...]:
    """The objects of an `objects.json`.

    Raises
    ------
    InputError
        Where a key is missing or a shape is unknown.
    """
    try:
        return tuple(_object_from_json(found) for found in document["objects"])
    except (KeyError, TypeError) as error:
        raise InputError(f"objects.json lacks {error}, which every object needs") from error


def _object_from_json(found: dict[str, Any]) -> FoundObject:
    parts = tuple(
        Part(
            role=part["role"],
            solid=from_parameters(part["shape"], part["parameters"]),
            hue_deg=part["hue_deg"],
            num_voxels=part["num_voxels"],
            rms=part["rms"],
        )
        for part in found["parts"]
    )
    return FoundObject(
        id=found["id"],
        label=found["label"],
        probability=found["probability"],
        centre=np.asarray(found["centre"], dtype=np.float64),
        size=np.asarray(found["size"], dtype=np.float64),
        num_voxels=found["num_voxels"],
        views=found["views"],
        parts=parts,
    )
