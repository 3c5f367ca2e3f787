"""Cells of twice, four times ... the size, for points too uncertain for those of the map."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud
from recon.voxelmap import archive
from recon.voxelmap.table import MAX_INDEX

if TYPE_CHECKING:
    from recon.voxelmap.voxelmap import VoxelMap

MAX_LEVEL = 6
"""Cells are at most 2^6 times as large as those of the map."""

Columns = Mapping[str, NDArray[Any]]


class CoarseMaps:
    """A map of each level that a point fell into; level k has cells 2^k times as large.

    Parameters
    ----------
    cell_size : float
        Of the map, world units.
    make : callable
        Makes an empty map of a cell size.
    """

    def __init__(self, cell_size: float, make: "Callable[[float], VoxelMap]") -> None:
        self.cell_size = cell_size
        self._make = make
        self.levels: dict[int, VoxelMap] = {}

    def insert(self, cloud: PointCloud) -> int:
        """Count each point in the finest cells that are as large as its sigma.

        Returns
        -------
        int
            How many points were counted: those beyond the coarsest cells, or out of reach, are not.
        """
        level = self._level_of(cloud)
        for number in np.unique(level[level > 0]).tolist():
            self._at(number).insert(cloud.select(level == number))
        return int((level > 0).sum())

    def _level_of(self, cloud: PointCloud) -> NDArray[np.int64]:
        """(N,) level of each point, 0 = none."""
        sigma = np.full(len(cloud), np.inf) if cloud.sigma is None else cloud.sigma
        known = np.isfinite(cloud.points).all(axis=1) & np.isfinite(sigma)
        known &= np.abs(cloud.points).max(axis=1, initial=0.0) < MAX_INDEX * self.cell_size
        ratio = np.maximum(np.where(known, sigma, 1.0) / self.cell_size, 2.0)
        level = np.ceil(np.log2(ratio)).astype(np.int64)
        return np.where(known & (level <= MAX_LEVEL), level, 0)

    def _at(self, level: int) -> "VoxelMap":
        if level not in self.levels:
            self.levels[level] = self._make(self.cell_size * 2.0**level)
        return self.levels[level]

    def merge(self, other: "CoarseMaps") -> None:
        """Add the levels of another map."""
        for level, theirs in sorted(other.levels.items()):
            self._at(level).merge(theirs)

    def crop_from(self, other: "CoarseMaps", low: Any, high: Any) -> None:
        """Take over the cells of another map whose middle lies between two corners."""
        for level, theirs in sorted(other.levels.items()):
            inside = theirs.cropped(low, high)
            if inside.num_cells:
                self.levels[level] = inside

    def columns(self) -> dict[str, NDArray[Any]]:
        """The arrays of a file."""
        found: dict[str, NDArray[Any]] = {}
        for level, one in sorted(self.levels.items()):
            for name, column in one.hit_columns().items():
                found[f"coarse{level}_{name}"] = column
        return found

    def restore(self, columns: Columns) -> None:
        """Take over the arrays of a file."""
        for level, own in enumerate(coarse_columns(columns), 1):
            if own:
                self._at(level).add_rows(archive.rows_of(own))


def coarse_columns(columns: Columns) -> list[dict[str, NDArray[Any]]]:
    """The arrays of a file that each level from 1 on left there; none of a level without cells."""
    prefixes = [f"coarse{level}_" for level in range(1, MAX_LEVEL + 1)]
    return [
        {name.removeprefix(prefix): c for name, c in columns.items() if name.startswith(prefix)}
        for prefix in prefixes
    ]
