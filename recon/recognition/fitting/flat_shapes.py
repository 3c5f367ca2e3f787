"""Plane and box: fitted by geometric distance."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.algebra import column_quantiles, num_parallel
from recon.records import Box, FitFailure, Plane, Solid

Array = NDArray[np.float64]

ENDS = np.array([0.01, 0.99])
"""Quantiles of the points between which a box starts."""
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
    """Points on a plane."""

    points: Array
    normals: Array
    surface = descent.PLANE
    num_parameters = 3

    def starts(self) -> list[Plane]:
        """The least-squares plane."""
        middle = self.points.mean(axis=0)
        vectors = np.linalg.eigh(np.cov((self.points - middle).T))[1]
        return [Plane(point=middle, normal=vectors[:, 0])]

    def packed(self, state: Plane) -> Array:
        """The numbers (6,) of a plane."""
        return np.concatenate([state.point, state.normal])

    def unpacked(self, numbers: Array) -> Plane:
        """The plane of its numbers."""
        return Plane(point=numbers[:3], normal=numbers[3:])

    def solid(self, state: Plane, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The plane with its point in the middle of the points."""
        middle = inliers.mean(axis=0)
        foot = middle - ((middle - state.point) @ state.normal) * state.normal
        return Plane(point=foot, normal=state.normal)


@dataclass(frozen=True, slots=True, eq=False)
class BoxModel:
    """Points on a box."""

    points: Array
    normals: Array
    surface = descent.BOX
    num_parameters = 9

    def starts(self) -> list[Box]:
        """Boxes along the principal axes of the points and along the most common normals."""
        moments = np.linalg.eigh(np.cov(self.points.T))[1].T
        return [self._around(axes) for axes in (moments, _commonest(self.normals))]

    def _around(self, axes: Array) -> Box:
        local = self.points @ axes.T
        low, high = column_quantiles(local, ENDS)
        return Box(centre=(low + high) / 2.0 @ axes, axes=axes, sizes=high - low)

    def packed(self, state: Box) -> Array:
        """The numbers (15,) of a box."""
        return np.concatenate([state.centre, state.axes.ravel(), state.sizes])

    def unpacked(self, numbers: Array) -> Box:
        """The box of its numbers."""
        return Box(centre=numbers[:3], axes=numbers[3:12].reshape(3, 3), sizes=numbers[12:])

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
        """The reason why the points do not show the faces of a box; empty if they do."""
        local = np.abs((self.points - state.centre) @ state.axes.T)
        face = np.argmax(local - state.sizes / 2.0, axis=1)
        along = np.abs(self.normals @ state.axes.T)[np.arange(len(face)), face]
        if (along > ALIGNED).mean() < ALIGNED_SHARE:
            return "the surface does not run along the faces of a box"
        if np.sort(np.bincount(face, minlength=3))[1] < SECOND_FACE * len(face):
            return "the points lie on one face of a box"
        return ""


def _commonest(normals: Array) -> Array:
    """(3, 3) unit rows: the most common normal, and the most common one perpendicular to it."""
    votes = num_parallel(normals, ALIKE)
    first = normals[np.argmax(votes)]
    flat = normals - (normals @ first)[:, None] * first
    length = np.linalg.norm(flat, axis=1)
    choice = np.argmax(votes * (length > ACROSS))
    if length[choice] <= ACROSS:
        return np.linalg.svd(first[None])[2]
    second = flat[choice] / length[choice]
    return np.stack([first, second, np.cross(first, second)])
