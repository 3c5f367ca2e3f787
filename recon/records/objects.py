"""Recognised objects and planes."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, one_line
from recon.records.extents import corners
from recon.records.solids import Plane, Solid, from_parameters, parameters

UNKNOWN = "unknown"

MAX_EXTENT = 2.0
"""Largest extent of a solid relative to its object, of which half may not have been seen."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """One solid of an object."""

    role: str
    """"crown", "body", ..., as the catalogue names it."""
    solid: Solid
    hue_deg: float | None
    """None if the part is grey or multicoloured."""
    num_voxels: int
    rms: float
    """Root mean square distance of the part's cells to the solid, world units."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoundingBox:
    """The upright box of smallest footprint around an object's cells."""

    centre: NDArray[np.float64]
    """(3,) world."""
    axes: NDArray[np.float64]
    """(3, 3) unit rows."""
    sizes: NDArray[np.float64]
    """(3,) full edge lengths along the axes."""
    unit: Literal["m"] | None
    """None if the scale of the world is unknown."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExplainingSolid:
    """One solid, and how much of an object it explains."""

    solid: Solid
    explained: float
    """Share of the cells that lie on it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundObject:
    """One object with its label; world coordinates and units."""

    id: int
    label: str
    """A name of the catalogue, or "unknown"."""
    probability: float | None
    """Of the label, 0 to 1; for "unknown", that it is of no known kind; None without a
    catalogue."""
    centre: NDArray[np.float64]
    """(3,) x, z on the fitted vertical axis, y halfway between the ground and the top; for an
    unknown, the centre of the box of its cell means."""
    size: NDArray[np.float64]
    """(3,) extent of the solids along the axes, from the ground up."""
    num_voxels: int
    views: int = 0
    """Number of pairs that put at least 10 points on it."""
    parts: tuple[Part, ...] = ()
    reason: str | None = None
    """Reason why it has no name; None if it has one."""
    nearest: tuple[tuple[str, float], ...] = ()
    """Nearest kinds with their probabilities, most probable first."""
    box: BoundingBox | None = None
    colour: tuple[int, int, int] | None = None
    """Dominant RGB colour of its cells."""
    seen: float | None = None
    """Share of its surface that cells cover, 0 to 1."""
    solid: ExplainingSolid | None = None
    """The one solid that explains its cells best."""
    pieces: int = 1
    """Number of convex pieces."""
    support: int | None = None
    """Id of the plane it stands on."""

    def holds(self, solid: Solid) -> bool:
        """True unless a solid extends far beyond the object: it fits only what was seen of it.

        So does a wide cylinder through a piece that is nearly flat. A plane, which has no end, is
        held.
        """
        extent = np.ptp(corners(solid), axis=0) if not isinstance(solid, Plane) else np.zeros(3)
        return bool(np.linalg.norm(extent) <= MAX_EXTENT * np.linalg.norm(self.size))


PlaneRole = Literal["ground", "support", "wall"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundPlane:
    """A large plane that objects stand on or in front of."""

    id: int
    point: NDArray[np.float64]
    """(3,) centre of its cells, world."""
    normal: NDArray[np.float64]
    """(3,) unit, towards the objects."""
    area: float
    """Of its cells, square world units."""
    role: PlaneRole


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recognition:
    """All objects of a map, and the failed fits."""

    objects: tuple[FoundObject, ...]
    label: NDArray[np.int32]
    """(K,) object id of each input cell; -1 = ground or none."""
    failures: dict[str, int] = field(default_factory=dict)
    """Number of failed fits, by reason."""
    planes: tuple[FoundPlane, ...] = ()
    """Planes that objects stand on or in front of."""

    def __repr__(self) -> str:
        labels = ", ".join(found.label for found in self.objects) or "none"
        return f"Recognition(objects: {labels}; {len(self.planes)} planes)"


def as_json(recognition: Recognition) -> dict[str, object]:
    """The document of `objects.json`."""
    return {
        "objects": [_object_json(found) for found in recognition.objects],
        "planes": [_plane_json(plane) for plane in recognition.planes],
        "failures": dict(sorted(recognition.failures.items())),
    }


def _object_json(found: FoundObject) -> dict[str, object]:
    return {
        "id": found.id,
        "label": found.label,
        "probability": None if found.probability is None else round(found.probability, 6),
        "reason": found.reason,
        "nearest": [[name, round(probability, 6)] for name, probability in found.nearest],
        "centre": found.centre.tolist(),
        "size": found.size.tolist(),
        "box": found.box and _box_json(found.box),
        "colour": found.colour and list(found.colour),
        "solid": found.solid and _solid_json(found.solid),
        "pieces": found.pieces,
        "seen": found.seen,
        "support": found.support,
        "num_voxels": found.num_voxels,
        "views": found.views,
        "parts": [_part_json(part) for part in found.parts],
    }


def _part_json(part: Part) -> dict[str, object]:
    return {
        "role": part.role,
        "shape": part.solid.kind,
        "parameters": parameters(part.solid),
        "hue_deg": part.hue_deg,
        "num_voxels": part.num_voxels,
        "rms": part.rms,
    }


def _box_json(box: BoundingBox) -> dict[str, object]:
    return {
        "centre": box.centre.tolist(),
        "axes": box.axes.tolist(),
        "sizes": box.sizes.tolist(),
        "unit": box.unit,
    }


def _solid_json(one: ExplainingSolid) -> dict[str, object]:
    return {
        "shape": one.solid.kind,
        "parameters": parameters(one.solid),
        "explained": one.explained,
    }


def _plane_json(plane: FoundPlane) -> dict[str, object]:
    return {
        "id": plane.id,
        "point": plane.point.tolist(),
        "normal": plane.normal.tolist(),
        "area": plane.area,
        "role": plane.role,
    }


def from_json(document: dict[str, Any]) -> tuple[FoundObject, ...]:
    """The objects of an `objects.json`; values missing in older runs are unknown.

    Raises
    ------
    InputError
        If a key is missing or a shape is unknown.
    """
    try:
        return tuple(_object_from_json(found) for found in document["objects"])
    except KeyError as error:
        raise InputError(f"objects.json lacks {error}, but every object needs it") from error
    except (TypeError, ValueError, AttributeError, IndexError) as error:
        raise InputError(f"objects.json is damaged ({one_line(error)})") from error


def _object_from_json(found: dict[str, Any]) -> FoundObject:
    return FoundObject(
        id=found["id"],
        label=found["label"],
        probability=found["probability"],
        centre=np.asarray(found["centre"], dtype=np.float64),
        size=np.asarray(found["size"], dtype=np.float64),
        num_voxels=found["num_voxels"],
        views=found["views"],
        parts=tuple(_part_from_json(part) for part in found["parts"]),
        reason=found.get("reason"),
        nearest=tuple((name, chance) for name, chance in found.get("nearest", [])),
        box=_box_from_json(found.get("box")),
        colour=tuple(found["colour"]) if found.get("colour") else None,
        seen=found.get("seen"),
        solid=_solid_from_json(found.get("solid")),
        pieces=found.get("pieces", 1),
        support=found.get("support"),
    )


def _part_from_json(part: dict[str, Any]) -> Part:
    return Part(
        role=part["role"],
        solid=from_parameters(part["shape"], part["parameters"]),
        hue_deg=part["hue_deg"],
        num_voxels=part["num_voxels"],
        rms=part["rms"],
    )


def _box_from_json(box: dict[str, Any] | None) -> BoundingBox | None:
    if box is None:
        return None
    arrays = {name: np.asarray(box[name], dtype=np.float64) for name in ("centre", "axes", "sizes")}
    return BoundingBox(**arrays, unit=box["unit"])


def _solid_from_json(one: dict[str, Any] | None) -> ExplainingSolid | None:
    if one is None:
        return None
    solid = from_parameters(one["shape"], one["parameters"])
    return ExplainingSolid(solid=solid, explained=one["explained"])
