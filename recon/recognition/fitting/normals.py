"""Surface normals from the neighbours of each point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.fitting.principal_axes import principal_normals

Array = NDArray[np.float64]

NUM_NEIGHBOURS = 12
"""Enough to average out noise, few enough to stay on one face."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Neighbourhoods:
    """The nearest neighbours of each point."""

    normals: Array
    """(N, 3) unit directions in which they vary least, away from the middle of the points."""
    thickness: Array
    """(N,) their standard deviation along the normal."""
    spacing: Array
    """(N,) distance to the nearest."""


def estimate_normals(points: Array) -> Array:
    """Unit normals (N, 3), pointing away from the middle of the points."""
    return neighbourhoods(points).normals


def neighbourhoods(points: Array) -> Neighbourhoods:
    """The neighbourhoods of points (N, 3)."""
    count = min(NUM_NEIGHBOURS, len(points))
    away, near = map(np.asarray, cKDTree(points).query(points, k=np.arange(1, count + 1)))
    normals, variances = principal_normals(np.ascontiguousarray(points), near)
    outward = np.einsum("ij,ij->i", normals, points - points.mean(axis=0))
    return Neighbourhoods(
        normals=np.where(outward < 0, -1.0, 1.0)[:, None] * normals,
        thickness=np.sqrt(variances),
        spacing=away[:, min(1, count - 1)],
    )
