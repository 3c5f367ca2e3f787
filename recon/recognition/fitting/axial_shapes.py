"""Cylinder and cone: straight lines rotated around a free axis, fitted by geometric distance.

In the half plane (t, rho), position along the axis and distance from it, both are the line
``cos(angle) rho - sin(angle) t = offset``; a cylinder's half angle is 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.algebra import quantiles, round_line, spread
from recon.records import Cone, Cylinder, FitFailure, Solid, TruncatedCone

Array = NDArray[np.float64]

NUM_STARTS = 3
"""Axes that are refined, out of all that are tried."""
PARALLEL = 0.998
"""Cosine of the angle below which two axes count as one."""
TIP_EVIDENCE = 4.6
"""A cone is truncated if evenly spread points would put this number on its missing tip (p = 1
%)."""
LARGEST_TO_EXTENT = 10.0
"""A radius larger than this multiple of the points' extent cannot be estimated from them."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """A line around an axis."""

    point: Array
    axis: Array
    offset: float
    angle: float


@dataclass(frozen=True, slots=True, eq=False)
class AxialModel:
    """Points on a cylinder or cone without ends."""

    points: Array
    normals: Array
    is_cone: bool

    @property
    def num_parameters(self) -> int:
        """Number of parameters of the surface."""
        return 6 if self.is_cone else 5

    @property
    def surface(self) -> int:
        """Number of the surface in `descent`."""
        return descent.CONE if self.is_cone else descent.CYLINDER

    def starts(self) -> list[Line]:
        """Algebraic fits around the most promising axes."""
        lines, away = self._algebraic(_axes(self.points, self.normals))
        return [lines[row] for row in np.argsort(away, kind="stable")[:NUM_STARTS]]

    def _algebraic(self, axes: Array) -> tuple[list[Line], Array]:
        """Lines round given axes (A, 3), and the median distances (A,) of the points to them."""
        middle = self.points.mean(axis=0)
        local = self.points - middle
        fits = [round_line(local, axis, self.is_cone) for axis in axes]
        lines = [
            Line(point=middle + point, axis=axis, offset=offset, angle=angle)
            for (point, offset, angle, _), axis in zip(fits, axes, strict=True)
        ]
        return lines, np.array([away for *_, away in fits])

    def packed(self, state: Line) -> Array:
        """The numbers (8,) of a line."""
        return np.concatenate([state.point, state.axis, [state.offset, state.angle]])

    def unpacked(self, numbers: Array) -> Line:
        """The line of its numbers."""
        return Line(
            point=numbers[:3],
            axis=numbers[3:6],
            offset=float(numbers[6]),
            angle=float(numbers[7]),
        )

    def solid(self, state: Line, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The solid, bounded by the ends of the points on it."""
        t = _within((inliers - state.point) @ state.axis)
        low, high = float(t.min()), float(t.max())
        slope = np.tan(state.angle)
        radii = state.offset / np.cos(state.angle) + slope * np.array([low, high])
        if np.abs(radii).max() > LARGEST_TO_EXTENT * float(np.ptp(inliers, axis=0).max()):
            return FitFailure("the radius is too large for the points")
        if not self.is_cone:
            return Cylinder(
                point=state.point + low * state.axis,
                axis=state.axis,
                radius=abs(float(radii[0])),
                height=high - low,
            )
        return _cone(state, (low, high), (float(radii[0]), float(radii[1])), len(inliers))


def _cone(
    state: Line, ends: tuple[float, float], radii: tuple[float, float], num_points: int
) -> Solid | FitFailure:
    (low, high), (first, last) = ends, radii
    axis, angle = state.axis, state.angle
    if last < first:
        # A cone narrows upwards: the wide end is the bottom.
        bottom, top, foot = first, last, low
    else:
        bottom, top, foot, axis, angle = last, first, high, -axis, -angle
    if bottom <= 0 or angle == 0.0:
        return FitFailure("the cone does not open")
    point = state.point + foot * state.axis
    height = high - low
    if num_points * (max(top, 0.0) / bottom) ** 2 < TIP_EVIDENCE:
        length = bottom / float(np.tan(-angle))
        return Cone(apex=point + length * axis, axis=-axis, half_angle_rad=-angle, height=length)
    return TruncatedCone(
        point=point, axis=axis, radius_bottom=bottom, radius_top=top, height=height
    )


def _within(t: Array) -> Array:
    """Positions along the axis without outliers: up to a fifth of the bulk's length beyond it."""
    low, high = quantiles(t, np.array([0.02, 0.98]))
    margin = 0.2 * (high - low)
    inside: Array = t[(t >= low - margin) & (t <= high + margin)]
    return inside


def _axes(points: Array, normals: Array) -> Array:
    """Candidate directions (A, 3): where normals vary least, and the principal axes of points."""
    moments = (normals.T @ normals, spread(normals), spread(points))
    vectors = [np.linalg.eigh(moment)[1].T for moment in moments]
    axes: list[Array] = []
    for axis in (vectors[0][0], vectors[1][0], *vectors[2]):
        if all(abs(axis @ other) < PARALLEL for other in axes):
            axes.append(axis)
    return np.stack(axes)
