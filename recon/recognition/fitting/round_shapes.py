"""Sphere and ellipsoid: fitted by their (first-order) geometric distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.records import Ellipsoid, FitFailure, Solid, Sphere

Array = NDArray[np.float64]

LARGEST_TO_EXTENT = 10.0
"""A radius larger than this multiple of the points' extent cannot be estimated from them."""

THINNEST = 6.0
"""Thickness, in noise scales, below which two sheets cannot be distinguished from one noisy
sheet."""


@dataclass(frozen=True, slots=True, eq=False)
class SphereModel:
    """Points on a sphere."""

    points: Array
    normals: Array
    surface = descent.SPHERE
    num_parameters = 4

    def starts(self) -> list[Sphere]:
        """The algebraic fit: ``|p|^2 = 2 c p + (r^2 - |c|^2)`` is linear in c and the rest."""
        middle = self.points.mean(axis=0)
        local = self.points - middle
        system = np.column_stack([2.0 * local, np.ones(len(local))])
        solution = np.linalg.lstsq(system, (local**2).sum(axis=1), rcond=None)[0]
        radius_sq = max(float(solution[3] + solution[:3] @ solution[:3]), 1e-300)
        return [Sphere(centre=middle + solution[:3], radius=float(np.sqrt(radius_sq)))]

    def packed(self, state: Sphere) -> Array:
        """The numbers (4,) of a sphere."""
        return np.append(state.centre, state.radius)

    def unpacked(self, numbers: Array) -> Sphere:
        """The sphere of its numbers."""
        return Sphere(centre=numbers[:3], radius=float(numbers[3]))

    def solid(self, state: Sphere, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The sphere itself, unless the points are too flat to show one."""
        extent = float(np.ptp(inliers, axis=0).max())
        if state.radius > LARGEST_TO_EXTENT * extent:
            return FitFailure("the sphere is too large for the points")
        return state


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stretch:
    """An ellipsoid as the symmetric matrix that maps it to the unit sphere."""

    centre: Array
    matrix: Array


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidModel:
    """Points on an ellipsoid."""

    points: Array
    normals: Array
    surface = descent.ELLIPSOID
    num_parameters = 9

    def starts(self) -> list[Stretch]:
        """The ellipsoids from the points' moments and from the algebraic sphere."""
        middle = self.points.mean(axis=0)
        values, vectors = np.linalg.eigh(np.cov((self.points - middle).T))
        radii = np.sqrt(3.0 * np.maximum(values, 1e-6 * values[-1]))
        moments = Stretch(centre=middle, matrix=vectors @ np.diag(1.0 / radii) @ vectors.T)
        ball = SphereModel(self.points, self.normals).starts()[0]
        return [moments, Stretch(centre=ball.centre, matrix=np.eye(3) / ball.radius)]

    def packed(self, state: Stretch) -> Array:
        """The numbers (12,) of an ellipsoid."""
        return np.concatenate([state.centre, state.matrix.ravel()])

    def unpacked(self, numbers: Array) -> Stretch:
        """The ellipsoid of its numbers."""
        return Stretch(centre=numbers[:3], matrix=numbers[3:].reshape(3, 3))

    def solid(self, state: Stretch, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The ellipsoid, radii descending, unless it is too large or too thin for the points."""
        values, vectors = np.linalg.eigh(state.matrix)
        extent = float(np.ptp(inliers, axis=0).max())
        if np.abs(values).min() * extent * LARGEST_TO_EXTENT < 1.0:
            return FitFailure("the ellipsoid is too long for the points")
        order = np.argsort(np.abs(values))
        radii = 1.0 / np.abs(values[order])
        if radii[-1] < THINNEST * sigma:
            return FitFailure("the ellipsoid is too thin for the noise")
        return Ellipsoid(centre=state.centre, radii=radii, axes=vectors.T[order])
