"""The solids that model parts of objects, in world coordinates and units.

Cylinders and cones are open: they have no caps. `distances` is the geometric distance of points (N,
3) to the finite surface of the solid, never negative.
"""

from dataclasses import dataclass
from typing import ClassVar, get_args

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

Array = NDArray[np.float64]
Parameters = dict[str, float | list[float] | list[list[float]]]

MOST_STEPS = 60
"""Upper bound; about ten steps suffice."""
CONVERGED = 1e-15
"""Relative step size at which the iteration has converged."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sphere:
    """All points at `radius` from `centre`."""

    kind: ClassVar[str] = "sphere"
    centre: Array
    """(3,)"""
    radius: float

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        away: Array = np.abs(np.linalg.norm(points - self.centre, axis=1) - self.radius)
        return away


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ellipsoid:
    """Half axes `radii` along the rows of `axes`."""

    kind: ClassVar[str] = "ellipsoid"
    centre: Array
    """(3,)"""
    radii: Array
    """(3,) descending."""
    axes: Array
    """(3, 3) unit rows."""

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        local = np.abs(self.axes @ (points - self.centre).T)
        foot = _foot_on_ellipsoid(local, self.radii)
        away: Array = np.linalg.norm(local - foot, axis=0)
        return away


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

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        profile = _profile(points, self.point, self.axis)
        return _to_segment(profile, (0.0, self.radius), (self.height, self.radius))


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

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        profile = _profile(points, self.apex, self.axis)
        radius = self.height * float(np.tan(self.half_angle_rad))
        return _to_segment(profile, (0.0, 0.0), (self.height, radius))


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

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        profile = _profile(points, self.point, self.axis)
        return _to_segment(profile, (0.0, self.radius_bottom), (self.height, self.radius_top))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plane:
    """The plane through `point` with normal `normal`."""

    kind: ClassVar[str] = "plane"
    point: Array
    """(3,)"""
    normal: Array
    """(3,) unit."""

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the plane."""
        away: Array = np.abs((points - self.point) @ self.normal)
        return away


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Box:
    """A box with edges `sizes` along the rows of `axes`."""

    kind: ClassVar[str] = "box"
    centre: Array
    """(3,)"""
    axes: Array
    """(3, 3) unit rows."""
    sizes: Array
    """(3,) full edge lengths."""

    def distances(self, points: Array) -> Array:
        """(N,) distances of points (N, 3) to the surface."""
        beyond = np.abs((points - self.centre) @ self.axes.T) - self.sizes / 2.0
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        inside = np.minimum(beyond.max(axis=1), 0.0)
        away: Array = outside - inside
        return away


Solid = Sphere | Ellipsoid | Cylinder | Cone | TruncatedCone | Plane | Box


@dataclass(frozen=True, slots=True)
class FitFailure:
    """The reason why no solid fits: a result, not an error. It is falsy; solids are truthy."""

    reason: str

    def __bool__(self) -> bool:
        return False


def parameters(solid: Solid) -> Parameters:
    """The parameters of a solid, named as in `objects.json`; angles in degrees."""
    numbers: Parameters = {}
    for name in type(solid).__slots__:
        value = getattr(solid, name)
        if name.endswith("_rad"):
            numbers[name.removesuffix("_rad") + "_deg"] = float(np.degrees(value))
        else:
            numbers[name] = np.asarray(value, dtype=np.float64).tolist()
    return numbers


def from_parameters(kind: str, numbers: Parameters) -> Solid:
    """The solid with the given `parameters`.

    Raises
    ------
    InputError
        For an unknown shape, or parameters of another shape.
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
        raise InputError(f"{kind} with {sorted(numbers)} is not a known solid") from error
    arrays = {
        name: np.asarray(value) if np.ndim(value) else value for name, value in values.items()
    }
    made: Solid = solid(**arrays)
    return made


def _profile(points: Array, origin: Array, axis: Array) -> Array:
    """Position along an axis and distance from it, (N, 2)."""
    offset = points - origin
    along = offset @ axis
    return np.column_stack([along, np.linalg.norm(offset - along[:, None] * axis, axis=1)])


def _to_segment(profile: Array, start: tuple[float, float], end: tuple[float, float]) -> Array:
    first, along = np.array(start), np.subtract(end, start)
    share = np.clip((profile - first) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
    away: Array = np.linalg.norm(profile - first - share[:, None] * along, axis=1)
    return away


def _foot_on_ellipsoid(local: Array, radii: Array) -> Array:
    """Nearest surface points (3, N) of points (3, N) in the positive octant.

    The foot of p is ``r^2 p / (t + r^2)`` for the one root t > -min(r)^2 of ``sum (r p / (t +
    r^2))^2 = 1``. The sum is decreasing and convex, so that Newton steps from below the root
    increase towards it; they start where no term exceeds 1.
    """
    scale = float(radii.max())
    squares = (radii[:, None] / scale) ** 2
    # Points on a plane of symmetry are moved slightly off it, which makes their root simple.
    points = np.maximum(local / scale, 1e-9)
    weighted = points * radii[:, None] / scale
    root = (weighted - squares).max(axis=0, initial=-np.inf)
    for _ in range(MOST_STEPS):
        from_pole = root + squares
        terms = (weighted / from_pole) ** 2
        step = (terms.sum(axis=0) - 1.0) / (2.0 * (terms / from_pole).sum(axis=0))
        root = root + np.maximum(step, 0.0)
        if (step <= CONVERGED * (1.0 + np.abs(root))).all():
            break
    foot: Array = scale * squares * points / (root + squares)
    return foot
