"""Plane and box: fitted by geometric distance."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.axes import across_axis
from recon.recognition.fitting.faces import to_box
from recon.records import Box, FitFailure, Plane, Solid

Array = NDArray[np.float64]

THINNEST = 6.0
"""Thickness, in noise scales, below which two sheets cannot be distinguished from one noisy
sheet."""

ALIGNED, ALIGNED_SHARE = 0.9, 0.5
"""Cosine between a point's normal and that of its face, and the share of points that must reach it:
on a sphere 0.3 do, whatever the axes."""
SECOND_FACE = 0.05
"""Share of the points of a box that must be on a second, non-parallel face."""

ALIKE, ACROSS = 0.98, 0.9
"""Cosine between two normals of one face, and sine between normals of adjacent faces."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneModel:
    """Distances of points to a plane; steps are a shift and two rotations."""

    points: Array
    normals: Array
    num_parameters = 3

    def starts(self) -> list[Plane]:
        """The least-squares plane."""
        middle = self.points.mean(axis=0)
        vectors = np.linalg.eigh(np.cov((self.points - middle).T))[1]
        return [Plane(point=middle, normal=vectors[:, 0])]

    def residuals(self, state: Plane) -> tuple[Array, Array]:
        """Signed distances (N,) and derivatives (N, 3)."""
        local = self.points - state.point
        across = across_axis(state.normal)
        return local @ state.normal, np.column_stack([-np.ones(len(local)), local @ across.T])

    def transformed(self, state: Plane, step: Array) -> Plane:
        """The plane after a step."""
        across = across_axis(state.normal)
        normal = state.normal + step[1:] @ across
        point = state.point + step[0] * state.normal
        return Plane(point=point, normal=normal / np.linalg.norm(normal))

    def solid(self, state: Plane, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The plane with its point in the middle of the points."""
        middle = inliers.mean(axis=0)
        foot = middle - ((middle - state.point) @ state.normal) * state.normal
        return Plane(point=foot, normal=state.normal)


@dataclass(frozen=True, slots=True, eq=False)
class BoxModel:
    """Distances of points to a box; steps are centre, rotation, half edges."""

    points: Array
    normals: Array
    num_parameters = 9

    def starts(self) -> list[Box]:
        """Boxes along the principal axes of the points and along the most common normals."""
        moments = np.linalg.eigh(np.cov(self.points.T))[1].T
        return [self._around(axes) for axes in (moments, _commonest(self.normals))]

    def _around(self, axes: Array) -> Box:
        local = self.points @ axes.T
        low, high = np.quantile(local, [0.01, 0.99], axis=0)
        return Box(centre=(low + high) / 2.0 @ axes, axes=axes, sizes=high - low)

    def residuals(self, state: Box) -> tuple[Array, Array]:
        """Signed distances (N,), negative inside, and derivatives (N, 9)."""
        signed, jacobian = to_box(self.points, state.centre, state.axes, state.sizes / 2.0)
        return signed, jacobian

    def transformed(self, state: Box, step: Array) -> Box:
        """The box after a step."""
        x, y, z = step[3:6]
        turn = np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
        axes = _orthonormal(turn @ state.axes)
        sizes = np.maximum(state.sizes + 2.0 * step[6:], 0.0)
        return replace(state, centre=state.centre + step[:3], axes=axes, sizes=sizes)

    def solid(self, state: Box, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The box, with faces that have no points moved to the nearest points."""
        if state.sizes.min() < THINNEST * sigma:
            return FitFailure("the box is too thin for the noise")
        local = (inliers - state.centre) @ state.axes.T
        fault = self._faceless(state)
        if fault:
            return FitFailure(fault)
        low = np.maximum(local.min(axis=0), -state.sizes / 2.0)
        high = np.minimum(local.max(axis=0), state.sizes / 2.0)
        middle = state.centre + (low + high) / 2.0 @ state.axes
        return replace(state, centre=middle, sizes=high - low)

    def _faceless(self, state: Box) -> str:
        """Why the points do not show the faces of a box; empty if they do."""
        local = np.abs((self.points - state.centre) @ state.axes.T)
        face = np.argmax(local - state.sizes / 2.0, axis=1)
        along = np.abs(self.normals @ state.axes.T)[np.arange(len(face)), face]
        if (along > ALIGNED).mean() < ALIGNED_SHARE:
            return "the surface does not run along the faces of a box"
        if np.sort(np.bincount(face, minlength=3))[1] < SECOND_FACE * len(face):
            return "the points lie on one face of a box"
        return ""


def _orthonormal(rows: Array) -> Array:
    """Orthonormalise three rows one after the other (Gram-Schmidt)."""
    first = rows[0] / np.sqrt(rows[0] @ rows[0])
    second = rows[1] - (rows[1] @ first) * first
    second = second / np.sqrt(second @ second)
    third = rows[2] - (rows[2] @ first) * first - (rows[2] @ second) * second
    return np.stack([first, second, third / np.sqrt(third @ third)])


def _commonest(normals: Array) -> Array:
    """(3, 3) unit rows: the most common normal, and the most common one perpendicular to it."""
    votes = (np.abs(normals @ normals.T) > ALIKE).sum(axis=0)
    first = normals[np.argmax(votes)]
    flat = normals - (normals @ first)[:, None] * first
    length = np.linalg.norm(flat, axis=1)
    choice = np.argmax(votes * (length > ACROSS))
    if length[choice] <= ACROSS:
        return np.linalg.svd(first[None])[2]
    second = flat[choice] / length[choice]
    return np.stack([first, second, np.cross(first, second)])
