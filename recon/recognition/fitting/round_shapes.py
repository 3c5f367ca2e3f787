"""Sphere and ellipsoid: fitted by their (first-order) geometric distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.sample import Sample
from recon.records import Ellipsoid, FitFailure, Solid, Sphere

Array = NDArray[np.float64]

LARGEST_TO_EXTENT = 10.0
"""A radius larger than this multiple of the points' extent cannot be estimated from them."""

THINNEST = 6.0
"""Thickness, in noise scales, below which two sheets cannot be distinguished from one noisy
sheet."""


@dataclass(frozen=True, slots=True, eq=False)
class SphereModel:
    """Points on a sphere, whose numbers are centre and radius."""

    sample: Sample
    surface = descent.SPHERE
    num_parameters = 4

    def starts(self) -> Array:
        """The algebraic fit (1, 4)."""
        ball = self.sample.ball
        return np.array([[*ball.centre, ball.radius]])

    def solid(self, numbers: Array, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The sphere itself, unless the points are too flat to show one."""
        extent = float(np.ptp(inliers, axis=0).max())
        radius = float(numbers[3])
        if radius > LARGEST_TO_EXTENT * extent:
            return FitFailure("the sphere is too large for the points")
        return Sphere(centre=numbers[:3], radius=radius)


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidModel:
    """Points on an ellipsoid: its centre, and the symmetric matrix that makes it a unit sphere."""

    sample: Sample
    surface = descent.ELLIPSOID
    num_parameters = 9

    def starts(self) -> Array:
        """The ellipsoids (2, 12) from the points' moments and from the algebraic sphere."""
        values, axes = self.sample.principal
        radii = np.sqrt(3.0 * np.maximum(values, 1e-6 * values[-1]))
        moments = axes.T @ np.diag(1.0 / radii) @ axes
        ball = self.sample.ball
        starts = (self.sample.middle, moments), (ball.centre, np.eye(3) / ball.radius)
        return np.stack([np.append(centre, matrix) for centre, matrix in starts])

    def solid(self, numbers: Array, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The ellipsoid, radii descending, unless it is too large or too thin for the points."""
        values, vectors = np.linalg.eigh(numbers[3:].reshape(3, 3))
        extent = float(np.ptp(inliers, axis=0).max())
        if np.abs(values).min() * extent * LARGEST_TO_EXTENT < 1.0:
            return FitFailure("the ellipsoid is too long for the points")
        order = np.argsort(np.abs(values))
        radii = 1.0 / np.abs(values[order])
        if radii[-1] < THINNEST * sigma:
            return FitFailure("the ellipsoid is too thin for the noise")
        return Ellipsoid(centre=numbers[:3], radii=radii, axes=vectors.T[order])
