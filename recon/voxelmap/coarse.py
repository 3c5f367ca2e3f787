"""Coarser levels of a map, for points too uncertain for its own cells."""

from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud
from recon.voxelmap import archive
from recon.voxelmap.table import MAX_INDEX, Rows

MAX_LEVEL = 6
"""Cells are at most 2^6 times as large as those of the map."""

Columns = Mapping[str, NDArray[Any]]


class _Level(Protocol):
    """A voxel map of one level."""

    has_colour: bool

    @property
    def num_cells(self) -> int: ...

    def insert(self, cloud: PointCloud) -> None: ...

    def merge(self, other: Self) -> None: ...

    def cropped(self, low: Any, high: Any) -> Self: ...

    def hit_columns(self) -> dict[str, NDArray[Any]]: ...

    def add_rows(self, rows: Rows) -> NDArray[np.int64]: ...


L = TypeVar("L", bound=_Level)


class CoarseMaps(Generic[L]):
    """One map per level into which a point fell; level k has cells 2^k times as large.

    Parameters
    ----------
    cell_size : float
        Cell size of the map itself, world units.
    make : callable
        Makes an empty map with a given cell size.
    """

    def __init__(self, cell_size: float, make: Callable[[float], L]) -> None:
        self.cell_size = cell_size
        self._make = make
        self.levels: dict[int, L] = {}

    def insert(self, cloud: PointCloud) -> int:
        """Count each point in the finest cells that are at least as large as its sigma.

        Returns
        -------
        int
            Number of points counted: not those beyond the coarsest cells, or out of reach.
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

    def _at(self, level: int) -> L:
        if level not in self.levels:
            self.levels[level] = self._make(self.cell_size * 2.0**level)
        return self.levels[level]

    def merge(self, other: "CoarseMaps[L]") -> None:
        """Add the levels of another map."""
        for level, theirs in sorted(other.levels.items()):
            self._at(level).merge(theirs)

    def crop_from(self, other: "CoarseMaps[L]", low: Any, high: Any) -> None:
        """Take over the cells of another map whose centres lie between two corners."""
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
        """Load the arrays of a file."""
        for level, own in enumerate(coarse_columns(columns), 1):
            if own:
                self._at(level).add_rows(archive.rows_of(own))
                self._at(level).has_colour = "colour" in own


def coarse_columns(columns: Columns) -> list[dict[str, NDArray[Any]]]:
    """The arrays of a file by level, from level 1; none for a level without cells."""
    prefixes = [f"coarse{level}_" for level in range(1, MAX_LEVEL + 1)]
    return [
        {name.removeprefix(prefix): c for name, c in columns.items() if name.startswith(prefix)}
        for prefix in prefixes
    ]
