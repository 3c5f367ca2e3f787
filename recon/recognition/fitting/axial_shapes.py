"""Cylinder and cone: straight lines rotated around a free axis, fitted by geometric distance.

In the half plane (t, rho), position along the axis and distance from it, both are the line
``cos(angle) rho - sin(angle) t = offset``; a cylinder's half angle is 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.algebra import quantiles, round_lines
from recon.recognition.fitting.sample import Sample
from recon.records import Cone, Cylinder, FitFailure, Solid, TruncatedCone

Array = NDArray[np.float64]

NUM_STARTS = 3
"""Axes that are refined, out of all that are tried."""
TIP_EVIDENCE = 4.6
"""A cone is truncated if evenly spread points would put this number on its missing tip (p = 1
%)."""
LARGEST_TO_EXTENT = 10.0
"""A radius larger than this multiple of the points' extent cannot be estimated from them."""


@dataclass(frozen=True, slots=True, eq=False)
class AxialModel:
    """Points on a cylinder or cone without ends: a point of its axis, this, offset and angle."""

    sample: Sample
    is_cone: bool

    @property
    def num_parameters(self) -> int:
        """Number of parameters of the surface."""
        return 6 if self.is_cone else 5

    @property
    def surface(self) -> int:
        """Number of the surface in `descent`."""
        return descent.CONE if self.is_cone else descent.CYLINDER

    def starts(self) -> Array:
        """Algebraic fits (S, 8) around the most promising axes."""
        lines, away = round_lines(self.sample.local, self.sample.axes, self.is_cone)
        lines[:, :3] += self.sample.middle
        starts: Array = lines[np.argsort(away, kind="stable")[:NUM_STARTS]]
        return starts

    def solid(self, numbers: Array, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The solid, bounded by the ends of the points on it."""
        point, axis, (offset, angle) = numbers[:3], numbers[3:6], numbers[6:].tolist()
        t = _within((inliers - point) @ axis)
        low, high = float(t.min()), float(t.max())
        radii = offset / np.cos(angle) + np.tan(angle) * np.array([low, high])
        if np.abs(radii).max() > LARGEST_TO_EXTENT * float(np.ptp(inliers, axis=0).max()):
            return FitFailure("the radius is too large for the points")
        if not self.is_cone:
            return Cylinder(
                point=point + low * axis,
                axis=axis,
                radius=abs(float(radii[0])),
                height=high - low,
            )
        return _cone(numbers, (low, high), (float(radii[0]), float(radii[1])), len(inliers))


def _cone(
    numbers: Array, ends: tuple[float, float], radii: tuple[float, float], num_points: int
) -> Solid | FitFailure:
    (low, high), (first, last) = ends, radii
    axis, angle = numbers[3:6], float(numbers[7])
    if last < first:
        # A cone narrows upwards: the wide end is the bottom.
        bottom, top, foot = first, last, low
    else:
        bottom, top, foot, axis, angle = last, first, high, -axis, -angle
    if bottom <= 0 or angle == 0.0:
        return FitFailure("the cone does not open")
    point = numbers[:3] + foot * numbers[3:6]
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
