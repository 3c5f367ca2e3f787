"""The content of a file for the inspector: points, cells or triangles, with columns of values."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import columns_of
from recon.records import Mesh, PointCloud, Voxels
from recon.voxelmap.faces import covered_faces

Array = NDArray[np.float64]
Data = PointCloud | Voxels | Mesh
GREY = 150
"""Grey level of data without colours."""

HIDDEN = {"red", "green", "blue", "cell_size", "index_x", "index_y", "index_z"}
MAX_COLUMNS = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """Elements that can be coloured, filtered, clicked and exported."""

    data: Data
    places: Array
    """(N, 3) world."""
    columns: Mapping[str, NDArray[np.float64]]
    """(N,) values by name."""
    triangles: NDArray[np.int32] | None = None
    """(T, 3) rows of `places`, for a mesh."""
    covered: NDArray[np.uint8] | None = None
    """(N,) faces of cells covered by a neighbour, as for `Raster.add_cells`."""
    order: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    """(N,) rows in random order: any first part is a sample of all."""

    def __len__(self) -> int:
        return len(self.places)

    @property
    def noun(self) -> str:
        """Name of the rows, in the plural."""
        if isinstance(self.data, Mesh):
            return "vertices"
        return "cells" if isinstance(self.data, Voxels) else "points"

    @property
    def colours(self) -> NDArray[np.uint8]:
        """(N, 3) RGB."""
        if self.data.colours is None:
            return np.full((len(self), 3), GREY, np.uint8)
        return self.data.colours

    @property
    def thickness(self) -> float:
        """Thickness of a slice: a cell, or a fiftieth of the longest side."""
        if isinstance(self.data, Voxels):
            return self.data.cell_size
        low, high = self.box
        return float((high - low).max()) / 50.0

    def select(self, rows: NDArray[np.bool_]) -> Data:
        """The data of the selected rows; for a mesh, triangles with all corners selected."""
        if not isinstance(self.data, Mesh):
            return self.data.select(np.flatnonzero(rows))
        kept = self.data.triangles[rows[self.data.triangles].all(axis=1)]
        used, renamed = np.unique(kept, return_inverse=True)
        colours, normals = self.data.colours, self.data.normals
        return Mesh(
            vertices=self.data.vertices[used],
            triangles=renamed.reshape(-1, 3).astype(np.int32),
            colours=None if colours is None else colours[used],
            normals=None if normals is None else normals[used],
        )

    @property
    def counts(self) -> NDArray[np.float64]:
        """(N,) points per cell; 1 for points."""
        return self.columns["count"] if "count" in self.columns else np.ones(len(self))

    @property
    def box(self) -> tuple[Array, Array]:
        """Lowest and highest corner (3,); half a unit around the origin if empty."""
        if not len(self):
            return np.full(3, -0.5), np.full(3, 0.5)
        return self.places.min(axis=0), self.places.max(axis=0)

    def values(self, row: int) -> dict[str, float]:
        """All values of one row, including its colour."""
        red, green, blue = (int(channel) for channel in self.colours[row])
        numbers = {name: float(column[row]) for name, column in self.columns.items()}
        return numbers | {"red": red, "green": green, "blue": blue}


def layer_of(data: Data, more: Mapping[str, NDArray[np.float64]] | None = None) -> Layer:
    """The layer of points or cells.

    Parameters
    ----------
    more : mapping of str to (N,), optional
        Columns besides those of the data.
    """
    columns = _columns(data) | dict(more or {})
    places = _places(data)
    if not np.isfinite(places).all():
        raise InputError("a position is not finite, but all must be")
    return Layer(
        data=data,
        places=places,
        columns=dict(list(columns.items())[:MAX_COLUMNS]),
        triangles=data.triangles if isinstance(data, Mesh) else None,
        covered=covered_faces(data) if isinstance(data, Voxels) else None,
        order=np.random.default_rng(0).permutation(len(places)),
    )


def _places(data: Data) -> Array:
    if isinstance(data, Mesh):
        return data.vertices
    return data.centres if isinstance(data, Voxels) else data.points


def _columns(data: Data) -> dict[str, NDArray[np.float64]]:
    if isinstance(data, Mesh):
        return dict(zip("xyz", data.vertices.T, strict=True))
    table = columns_of(data)
    return {name: np.asarray(one, np.float64) for name, one in table.items() if name not in HIDDEN}
