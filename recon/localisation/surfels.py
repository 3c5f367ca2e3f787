"""Surfels: the occupied cells of a map as small pieces of surface with normals."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.geometry import transform
from recon.records import Voxels

Array = NDArray[np.float64]

NUM_NEIGHBOURS = 20
REACH = 2.5
"""Radius in cells of the neighbours that determine the normal."""
MIN_NEIGHBOURS = 5
MAX_THICKNESS = 0.3
"""Maximum ratio of the two smallest variances of a piece of surface."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surfels:
    """Cells as pieces of surface, with normals from their neighbours."""

    means: Array
    """(K, 3) mean positions, world."""
    normals: Array
    """(K, 3) unit normals, of either sign."""
    is_flat: NDArray[np.bool_]
    """(K,) True if the neighbours agree on a normal."""
    cell_size: float
    tree: cKDTree = field(repr=False)
    """Tree of the means."""

    def __len__(self) -> int:
        return len(self.means)

    @classmethod
    def of(cls, voxels: Voxels) -> "Surfels":
        """The surfels of occupied cells."""
        return cls.through(voxels.means.reshape(-1, 3), voxels.cell_size)

    @classmethod
    def through(cls, means: Array, cell_size: float) -> "Surfels":
        """Surfels at points (K, 3), with normals of planes through their neighbours."""
        tree = cKDTree(means)
        reach = REACH * cell_size
        distance, row = tree.query(means, k=NUM_NEIGHBOURS, distance_upper_bound=reach)
        found = np.isfinite(distance)
        points = means[np.where(found, row, 0)]
        number = np.maximum(found.sum(axis=1), 1)
        centre = np.einsum("nki,nk->ni", points, found) / number[:, None]
        offsets = (points - centre[:, None]) * found[..., None]
        spread = np.einsum("nki,nkj->nij", offsets, offsets) / number[:, None, None]
        variance, axes = np.linalg.eigh(spread)
        is_thin = variance[:, 0] < MAX_THICKNESS * variance[:, 1]
        return cls(
            means=means,
            normals=axes[:, :, 0],
            is_flat=is_thin & (number >= MIN_NEIGHBOURS),
            cell_size=cell_size,
            tree=tree,
        )

    def moved(self, T_a_b: Array) -> "Surfels":
        """The same surfels, from frame b to frame a."""
        means = transform(T_a_b, self.means)
        return replace(
            self, means=means, normals=self.normals @ T_a_b[:3, :3].T, tree=cKDTree(means)
        )

    def under(self, points: Array, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The rows of points (N, 3) with a flat surfel within reach, and the surfels' rows."""
        distance, nearest = self.tree.query(points, distance_upper_bound=reach)
        surfel = np.asarray(nearest, dtype=np.intp)
        rows = np.flatnonzero(np.isfinite(distance))
        rows = rows[self.is_flat[surfel[rows]]]
        return rows, surfel[rows]
