"""The solids that parts of objects are made of, in world coordinates and units."""

from dataclasses import dataclass
from typing import ClassVar, get_args

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

Array = NDArray[np.float64]
Parameters = dict[str, float | list[float] | list[list[float]]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sphere:
    """All points at `radius` from `centre`."""

    kind: ClassVar[str] = "sphere"
    centre: Array
    """(3,)"""
    radius: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ellipsoid:
    """Half axes `radii` along the rows of `axes`."""

    kind: ClassVar[str] = "ellipsoid"
    centre: Array
    """(3,)"""
    radii: Array
    """(3,) falling."""
    axes: Array
    """(3, 3) unit rows."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cylinder:
    """An open cylinder from `point`, `height` along `axis`."""

    kind: ClassVar[str] = "cylinder"
    point: Array
    """(3,) middle of the base."""
    axis: Array
    """(3,) unit."""
    radius: float
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cone:
    """An open cone that widens from `apex` along `axis` over `height`."""

    kind: ClassVar[str] = "cone"
    apex: Array
    """(3,)"""
    axis: Array
    """(3,) unit, from the apex into the cone."""
    half_angle_rad: float
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TruncatedCone:
    """An open frustum from `point`, `height` along `axis`."""

    kind: ClassVar[str] = "truncated cone"
    point: Array
    """(3,) middle of the bottom."""
    axis: Array
    """(3,) unit, from the bottom to the top."""
    radius_bottom: float
    radius_top: float
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plane:
    """The plane through `point` across `normal`."""

    kind: ClassVar[str] = "plane"
    point: Array
    """(3,)"""
    normal: Array
    """(3,) unit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Box:
    """A box with edges `sizes` along the rows of `axes`."""

    kind: ClassVar[str] = "box"
    centre: Array
    """(3,)"""
    axes: Array
    """(3, 3) unit rows."""
    sizes: Array
    """(3,) whole edges."""


Solid = Sphere | Ellipsoid | Cylinder | Cone | TruncatedCone | Plane | Box


@dataclass(frozen=True, slots=True)
class FitFailure:
    """Why no solid fits: an answer, not an error. It is false where a solid is true."""

    reason: str

    def __bool__(self) -> bool:
        return False


def parameters(solid: Solid) -> Parameters:
    """The numbers of a solid by the names of `objects.json`; angles in degrees."""
    numbers: Parameters = {}
    for name in type(solid).__slots__:
        value = getattr(solid, name)
        if name.endswith("_rad"):
            numbers[name.removesuffix("_rad") + "_deg"] = float(np.degrees(value))
        else:
            numbers[name] = np.asarray(value, dtype=np.float64).tolist()
    return numbers


def from_parameters(kind: str, numbers: Parameters) -> Solid:
    """The solid that `parameters` described.

    Raises
    ------
    InputError
        For a shape that is none of the solids, and for parameters that are not its own.
    """
    try:
        solid = next(solid for solid in get_args(Solid) if solid.kind == kind)
        values = {
            name: numbers[name]
            if name in numbers
            else np.radians(numbers[name.replace("_rad", "_deg")])
            for name in solid.__slots__
        }
    except (StopIteration, KeyError) as error:
        raise InputError(f"{kind} with {sorted(numbers)} is no solid that recon knows") from error
    arrays = {
        name: np.asarray(value) if np.ndim(value) else value for name, value in values.items()
    }
    made: Solid = solid(**arrays)
    return made
