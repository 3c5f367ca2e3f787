"""Cylinder and cone: straight lines rotated around a free axis, fitted by geometric distance.

In the half plane (t, rho), position along the axis and distance from it, both are the line
``cos(angle) rho - sin(angle) t = offset``; a cylinder's half angle is 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.axes import across_axis
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
        """Lines round given axes (A, 3), and the median distances (A,) of the points to them.

        ``x^2 + y^2 = 2 a x + 2 b y + c (+ d t + e t^2)`` is linear.
        """
        middle = self.points.mean(axis=0)
        across = np.stack([across_axis(axis) for axis in axes])
        local = np.concatenate([across, axes[:, None]], axis=1) @ (self.points - middle).T
        xy, t = local[:, :2], local[:, 2]
        columns = [*(2.0 * xy).swapaxes(0, 1), np.ones_like(t)]
        columns += [t, t * t] if self.is_cone else []
        centres = _least_squares(np.stack(columns, axis=1), (xy**2).sum(axis=1))[:, :2]
        rho = np.linalg.norm(xy - centres[:, :, None], axis=1)
        angles = _slopes(t, rho) if self.is_cone else np.zeros(len(axes))
        level = np.cos(angles)[:, None] * rho - np.sin(angles)[:, None] * t
        offsets = np.median(level, axis=1)
        points = middle + np.einsum("ak,akj->aj", centres, across)
        lines = [
            Line(point=point, axis=axis, offset=float(offset), angle=float(angle))
            for point, axis, offset, angle in zip(points, axes, offsets, angles, strict=True)
        ]
        return lines, np.median(np.abs(level - offsets[:, None]), axis=1)

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
    low, high = np.quantile(t, [0.02, 0.98])
    margin = 0.2 * (high - low)
    inside: Array = t[(t >= low - margin) & (t <= high + margin)]
    return inside


def _least_squares(columns: Array, values: Array) -> Array:
    """Solutions (A, P) of linear systems with columns (A, P, N) for values (A, N)."""
    normal = columns @ columns.swapaxes(1, 2)
    solutions = np.linalg.pinv(normal, hermitian=True) @ (columns @ values[:, :, None])
    found: Array = solutions[:, :, 0]
    return found


def _slopes(t: Array, rho: Array) -> Array:
    """Angles (A,) of the principal directions of points (A, N) to the axis."""
    t, rho = (values - values.mean(axis=1, keepdims=True) for values in (t, rho))
    twice = np.arctan2(2.0 * (t * rho).sum(axis=1), (t**2).sum(axis=1) - (rho**2).sum(axis=1))
    angles: Array = twice / 2.0
    return angles


def _axes(points: Array, normals: Array) -> Array:
    """Candidate directions (A, 3): where normals vary least, and the principal axes of points."""
    moments = (normals.T @ normals, np.cov(normals.T), np.cov(points.T))
    vectors = [np.linalg.eigh(moment)[1].T for moment in moments]
    axes: list[Array] = []
    for axis in (vectors[0][0], vectors[1][0], *vectors[2]):
        if all(abs(axis @ other) < PARALLEL for other in axes):
            axes.append(axis)
    return np.stack(axes)
