"""Plane and box: fitted by geometric distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting import descent
from recon.recognition.fitting.algebra import column_quantiles, num_parallel
from recon.recognition.fitting.sample import Sample
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
    """Points on a plane, whose numbers are a point and the normal."""

    sample: Sample
    surface = descent.PLANE
    num_parameters = 3

    def starts(self) -> Array:
        """The least-squares plane (1, 6)."""
        return np.append(self.sample.middle, self.sample.principal[1][0])[None]

    def solid(self, numbers: Array, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The plane with its point in the middle of the points."""
        middle, normal = inliers.mean(axis=0), numbers[3:]
        foot = middle - ((middle - numbers[:3]) @ normal) * normal
        return Plane(point=foot, normal=normal)


@dataclass(frozen=True, slots=True, eq=False)
class BoxModel:
    """Points on a box, whose numbers are centre, axes and edges."""

    sample: Sample
    surface = descent.BOX
    num_parameters = 9

    def starts(self) -> Array:
        """Boxes (2, 15) along the principal axes and along the most common normals."""
        frames = self.sample.principal[1], _commonest(self.sample.normals)
        return np.stack([self._around(axes) for axes in frames])

    def _around(self, axes: Array) -> Array:
        low, high = column_quantiles(self.sample.points @ axes.T, ENDS)
        return np.concatenate([(low + high) / 2.0 @ axes, axes.ravel(), high - low])

    def solid(self, numbers: Array, inliers: Array, sigma: float) -> Solid | FitFailure:
        """The box, with faces that have no points moved to the nearest points."""
        centre, axes, sizes = numbers[:3], numbers[3:12].reshape(3, 3), numbers[12:]
        if sizes.min() < THINNEST * sigma:
            return FitFailure("the box is too thin for the noise")
        local = (inliers - centre) @ axes.T
        fault = self._faceless(centre, axes, sizes)
        if fault:
            return FitFailure(fault)
        low = np.maximum(local.min(axis=0), -sizes / 2.0)
        high = np.minimum(local.max(axis=0), sizes / 2.0)
        return Box(centre=centre + (low + high) / 2.0 @ axes, axes=axes, sizes=high - low)

    def _faceless(self, centre: Array, axes: Array, sizes: Array) -> str:
        """The reason why the points do not show the faces of a box; empty if they do."""
        local = np.abs((self.sample.points - centre) @ axes.T)
        face = np.argmax(local - sizes / 2.0, axis=1)
        along = np.abs(self.sample.normals @ axes.T)[np.arange(len(face)), face]
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
