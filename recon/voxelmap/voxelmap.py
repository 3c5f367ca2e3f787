"""The voxel map: whatever the order of its points, the same bits."""

import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError
from recon.records import PointCloud, Voxels
from recon.voxelmap import archive, hits
from recon.voxelmap.table import MAX_INDEX, CellTable, Rows


class VoxelMap:
    """Counts, mean positions and mean colours of points in cubic cells, without bounds.

    The grid is anchored at 0: a point lies in the cell floor(point / cell_size). Cells keep sums
    of whole numbers only, so that insertion order, chunks and merging do not change a bit; a
    position is kept to 1e-6 of a cell.

    Parameters
    ----------
    cell_size : float
        Side of a cell, world units.
    """

    def __init__(self, cell_size: float = 1.0) -> None:
        if not (np.isfinite(cell_size) and cell_size > 0):
            raise InputError(f"cell_size is {cell_size}, but a positive number is needed")
        self.cell_size = float(cell_size)
        self._hits = CellTable(hits.NARROW)

    @property
    def num_cells(self) -> int:
        """Number of cells that hold a point."""
        return self._hits.num_rows

    @property
    def nbytes(self) -> int:
        """Memory that the cells take."""
        return self._hits.nbytes

    def insert(
        self, cloud: PointCloud, origin: ArrayLike | None = None, view: int | None = None
    ) -> None:
        """Add the points of one view, given in the world.

        Parameters
        ----------
        cloud : PointCloud
        origin : (3,) array_like, optional
            Where the points were seen from; the space between is free. World.
        view : int, optional
            Number of the view.
        """
        points = np.ascontiguousarray(cloud.points, dtype=np.float64)
        self._check_reach(points)
        colours = np.ascontiguousarray(cloud.colours)
        stop = 0
        while stop < len(points):
            stop, self._hits.num_rows = hits.insert(
                points, colours, self.cell_size, self._capacity, self._hits.arrays, stop
            )
            self._make_room(stop < len(points))

    def merge(self, other: "VoxelMap") -> None:
        """Add all that another map of the same cells holds; it stays as it is."""
        if other.cell_size != self.cell_size:
            raise InputError(
                f"the other map's cell_size is {other.cell_size}, but {self.cell_size} is needed"
            )
        # A copy, as the map may be merged with itself.
        self._add_rows(other._hits.used.copy())

    def occupied(self, min_count: int = 5) -> Voxels:
        """The cells with at least `min_count` points, ordered by x, then y, then z."""
        rows = self._hits.used
        return self._voxels(in_order(rows[rows["count"] >= min_count]))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map, whole or not at all."""
        archive.save(path, in_order(self._hits.used), self.cell_size)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "VoxelMap":
        """Read a map that `save` wrote; the same cells to the last bit.

        Raises
        ------
        InputError
            For a file that is cut short, is of another version or claims what it does not hold.
        """
        rows, cell_size = archive.load(path)
        loaded = cls(cell_size)
        loaded._add_rows(rows)
        return loaded

    def _check_reach(self, points: NDArray[np.float64]) -> None:
        farthest = np.abs(points).max(initial=0.0)
        # Written so that NaN fails too.
        if not farthest < MAX_INDEX * self.cell_size:
            raise InputError(
                f"points hold {farthest}, but finite numbers within "
                f"{MAX_INDEX * self.cell_size:g} are needed"
            )

    @property
    def _capacity(self) -> int:
        return hits.CAPACITY[self._hits.rows.dtype]

    def _make_room(self, is_stopped: bool) -> None:
        if self._hits.is_full:
            self._hits.grow()
        elif is_stopped:
            self._widen()

    def _widen(self) -> None:
        if self._hits.rows.dtype == hits.WIDE:
            raise InputError(f"a cell holds more than {self._capacity} points, which is its limit")
        self._hits.widen(hits.WIDE)

    def _add_rows(self, rows: Rows) -> None:
        if rows.dtype == hits.WIDE and self._hits.rows.dtype != hits.WIDE:
            self._widen()
        stop = 0
        while stop < len(rows):
            stop, self._hits.num_rows = hits.merge(rows, self._capacity, self._hits.arrays, stop)
            self._make_room(stop < len(rows))

    def _voxels(self, rows: Rows) -> Voxels:
        index = rows["index"].astype(np.int64)
        counts = rows["count"].astype(np.int64)
        # A position is the middle of its step.
        inside = (rows["position"] / counts[:, None] + 0.5) / hits.STEPS
        twice = 2 * counts[:, None]
        colours = (2 * rows["colour"].astype(np.int64) + counts[:, None]) // twice
        return Voxels(
            index=index,
            centres=(index.astype(np.float64) + 0.5) * self.cell_size,
            means=(index + inside) * self.cell_size,
            counts=counts,
            colours=colours.astype(np.uint8),
            cell_size=self.cell_size,
        )


def in_order(rows: Rows) -> Rows:
    """Rows sorted by their index: x, then y, then z."""
    x, y, z = rows["index"].T
    return rows[np.lexsort((z, y, x))]
