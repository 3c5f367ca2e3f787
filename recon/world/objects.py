"""The true objects of a scene: solids stacked on a common upright axis."""

import math
from dataclasses import dataclass

import numpy as np

from recon.geometry import Array
from recon.records import UNKNOWN
from recon.world.solids import Triangles, quarter_turns
from recon.world.visuals import (
    CylinderVisual,
    EllipsoidVisual,
    PolygonVisual,
    SphereVisual,
    Visual,
)

TOUCH = 0.1
"""Maximum distance of the axes or ends of two parts of one object, in eye heights."""

COTTAGE_SHARE = 0.6
"""Minimum width of a cottage's body relative to the cone on it; a thinner body makes a pine."""

LAMP_POST = 13.0
"""A body higher than this many times its radius carries a lamp, not a crown."""

MAX_LEAN = 0.1
"""Sine of the maximum tilt of an upright part."""

GROUND_SLOPE = 0.1
"""Maximum slope of the ground, radians."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrueObject:
    """An object of the scene; world coordinates and units."""

    id: int
    label: str
    """A name of the catalogue, or "unknown"."""
    centre: Array
    """(3,) x, z on the axis, y halfway between the ground and the top."""
    size: Array
    """(3,) extent along the axes, from the ground up."""
    visuals: tuple[int, ...]
    """Indices of its parts in the scene, from the bottom up."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Part:
    number: int
    low: Array
    high: Array
    is_plane: bool

    @property
    def middle(self) -> Array:
        return 0.5 * (self.low + self.high)


def is_ground(visual: Visual, triangles: Triangles, eye_height: float) -> bool:
    """Determine whether a visual is a polygon that lies flat at height 0."""
    if not isinstance(visual, PolygonVisual) or not len(triangles.corners):
        return False
    is_level = np.abs(triangles.normals[..., 1]).min() >= math.cos(GROUND_SLOPE)
    return bool(is_level and triangles.corners[..., 1].min() <= TOUCH * eye_height)


def true_objects(
    visuals: tuple[Visual, ...], triangles: list[Triangles], eye_height: float
) -> tuple[TrueObject, ...]:
    """Objects in the order of their first visual, without the ground."""
    parts = [
        _part(number, part, isinstance(visual, PolygonVisual))
        for number, (visual, part) in enumerate(zip(visuals, triangles, strict=True))
        if len(part.corners) and not is_ground(visual, part, eye_height)
    ]
    groups = _groups(parts, TOUCH * eye_height)
    return tuple(_object(number, group, visuals) for number, group in enumerate(groups))


def _part(number: int, part: Triangles, is_plane: bool) -> _Part:
    points = part.corners.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    return _Part(number=number, low=low, high=high, is_plane=is_plane)


def _groups(parts: list[_Part], touch: float) -> list[list[_Part]]:
    """Parts grouped as long as one is within `touch` of a group on its axis."""
    groups: list[list[_Part]] = []
    for part in parts:
        touching = [g for g in groups if any(_belong(part, other, touch) for other in g)]
        merged = [part, *(other for group in touching for other in group)]
        groups = [g for g in groups if g not in touching]
        groups.append(merged)
    groups.sort(key=lambda group: min(part.number for part in group))
    return [sorted(group, key=lambda part: part.middle[1]) for group in groups]


def _belong(a: _Part, b: _Part, touch: float) -> bool:
    if a.is_plane or b.is_plane:
        return bool(np.maximum(a.low - b.high, b.low - a.high).max() <= touch)
    apart = np.hypot(*(a.middle - b.middle)[[0, 2]])
    gap = max(a.low[1], b.low[1]) - min(a.high[1], b.high[1])
    return bool(apart <= touch and gap <= touch)


def _object(number: int, group: list[_Part], visuals: tuple[Visual, ...]) -> TrueObject:
    low = np.min([part.low for part in group], axis=0)
    high = np.max([part.high for part in group], axis=0)
    low[1] = min(low[1], 0.0)
    return TrueObject(
        id=number,
        label=_label([visuals[part.number] for part in group]),
        centre=0.5 * (low + high),
        size=high - low,
        visuals=tuple(part.number for part in group),
    )


def _label(visuals: list[Visual]) -> str:
    """The name of a crown on a body (thesis 4.5), or of planes and bars."""
    if any(isinstance(visual, PolygonVisual) for visual in visuals):
        return _label_of_planes(visuals)
    if len(visuals) != 2:
        return UNKNOWN
    body, crown = visuals
    if not isinstance(body, CylinderVisual) or not _is_upright(body) or _is_cone(body):
        return UNKNOWN
    if isinstance(crown, SphereVisual | EllipsoidVisual):
        return "lamp post" if body.height > LAMP_POST * body.radius_base else "apple tree"
    if isinstance(crown, CylinderVisual) and _is_upright(crown) and _is_cone(crown):
        widest = max(crown.radius_base, crown.radius_top)
        return "cottage" if body.radius_base >= COTTAGE_SHARE * widest else "pine tree"
    return UNKNOWN


def _label_of_planes(visuals: list[Visual]) -> str:
    """The name by the numbers of level, sloping and upright planes, and of legs."""
    rises = [_rise(visual) for visual in visuals if isinstance(visual, PolygonVisual)]
    num_level = sum(rise < MAX_LEAN for rise in rises)
    num_upright = sum(rise > 1.0 - MAX_LEAN for rise in rises)
    num_sloping = len(rises) - num_level - num_upright
    num_legs = len(visuals) - len(rises)
    if num_sloping and num_upright >= 2:
        return "house"
    if num_level == 1 and num_legs >= 2:
        return "bench" if num_upright else "table"
    return UNKNOWN


def _rise(polygon: PolygonVisual) -> float:
    """Steepness of a polygon: 0 level, 1 upright."""
    points = np.array([vertex.position for vertex in polygon.vertices])
    normal = np.linalg.svd(points - points.mean(axis=0))[2][-1]
    return float(np.hypot(normal[0], normal[2]))


def _is_cone(visual: CylinderVisual) -> bool:
    return visual.radius_base != visual.radius_top


def _is_upright(visual: CylinderVisual) -> bool:
    axis = quarter_turns(visual.rotation)[:, 2]
    return bool(np.hypot(axis[0], axis[2]) < MAX_LEAN)
