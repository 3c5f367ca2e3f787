"""Surface normals from the neighbours of each point."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]

NUM_NEIGHBOURS = 12
"""Enough to average out noise, few enough to stay on one face."""


def estimate_normals(points: Array, num_neighbours: int = NUM_NEIGHBOURS) -> Array:
    """Unit normals (N, 3), pointing away from the middle of the points.

    Each is the direction in which the point's nearest neighbours vary least.
    """
    count = min(num_neighbours, len(points))
    _, near = cKDTree(points).query(points, k=count)
    patches = points[near.reshape(len(points), -1)]
    patches = patches - patches.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", patches, patches))
    normals = vectors[:, :, 0]
    outward = np.einsum("ij,ij->i", normals, points - points.mean(axis=0))
    oriented: Array = np.where(outward < 0, -1.0, 1.0)[:, None] * normals
    return oriented
