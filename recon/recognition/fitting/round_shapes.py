"""Sphere and ellipsoid: fitted by their (first-order) geometric distance."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.records import Ellipsoid, FitFailure, Solid, Sphere

Array = NDArray[np.float64]

LARGEST_TO_EXTENT = 10.0
"""A radius larger than this multiple of the points' extent cannot be estimated from them."""

THINNEST = 6.0
"""Thickness, in noise scales, below which two sheets cannot be distinguished from one noisy
sheet."""


@dataclass(frozen=True, slots=True, eq=False)
class SphereModel:
    """Distances of points to a sphere; steps are centre, radius."""

    points: Array
    normals: Array
    num_parameters = 4

    def starts(self) -> list[Sphere]:
        """The algebraic fit: ``|p|^2 = 2 c p + (r^2 - |c|^2)`` is linear in c and the rest."""
        middle = self.points.mean(axis=0)
        local = self.points - middle
        system = np.column_stack([2.0 * local, np.ones(len(local))])
        solution = np.linalg.lstsq(system, (local**2).sum(axis=1), rcond=None)[0]
        radius_sq = max(float(solution[3] + solution[:3] @ solution[:3]), 1e-300)
        return [Sphere(centre=middle + solution[:3], radius=float(np.sqrt(radius_sq)))]

    def residuals(self, state: Sphere) -> tuple[Array, Array]:
        """Signed distances (N,) and derivatives (N, 4)."""
        offset = self.points - state.centre
        length = np.maximum(np.linalg.norm(offset, axis=1), 1e-300)
        jacobian = np.column_stack([-offset / length[:, None], -np.ones(len(length))])
        return length - state.radius, jacobian

    def transformed(self, state: Sphere, step: Array) -> Sphere:
        """The sphere after a step."""
        return Sphere(centre=state.centre + step[:3], radius=abs(state.radius + float(step[3])))

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


_ROWS, _COLUMNS = np.triu_indices(3)


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidModel:
    """Distances of points to an ellipsoid; steps are the centre, then the six matrix entries."""

    points: Array
    normals: Array
    num_parameters = 9

    def starts(self) -> list[Stretch]:
        """The ellipsoids from the points' moments and from the algebraic sphere."""
        middle = self.points.mean(axis=0)
        values, vectors = np.linalg.eigh(np.cov((self.points - middle).T))
        radii = np.sqrt(3.0 * np.maximum(values, 1e-6 * values[-1]))
        moments = Stretch(centre=middle, matrix=vectors @ np.diag(1.0 / radii) @ vectors.T)
        ball = SphereModel(self.points, self.normals).starts()[0]
        return [moments, Stretch(centre=ball.centre, matrix=np.eye(3) / ball.radius)]

    def residuals(self, state: Stretch) -> tuple[Array, Array]:
        """Signed first-order distances (N,) and derivatives (N, 9)."""
        offset = self.points - state.centre
        image = offset @ state.matrix
        level = np.maximum(np.linalg.norm(image, axis=1), 1e-12)
        slope = image @ state.matrix / level[:, None]
        scale = 1.0 / np.maximum(np.linalg.norm(slope, axis=1), 1e-300)
        twice = np.where(_ROWS == _COLUMNS, 0.5, 1.0)
        by_matrix = image[:, _ROWS] * offset[:, _COLUMNS] + image[:, _COLUMNS] * offset[:, _ROWS]
        jacobian = np.column_stack([-slope, by_matrix * twice / level[:, None]])
        return (level - 1.0) * scale, jacobian * scale[:, None]

    def transformed(self, state: Stretch, step: Array) -> Stretch:
        """The ellipsoid after a step."""
        change = np.zeros((3, 3))
        change[_ROWS, _COLUMNS] = change[_COLUMNS, _ROWS] = step[3:]
        return replace(state, centre=state.centre + step[:3], matrix=state.matrix + change)

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
