"""The dense cloud of many views: one point per cell, with a sigma from its views."""

from itertools import product

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import PointCloud
from recon.surface.depth import DepthMap, Floats
from recon.voxelmap.table import CellTable, Rows, Slots, find_or_add

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

_CELL = np.dtype(
    [
        ("index", np.int32, (3,)),
        ("last_view", np.int32),
        ("num_pixels", np.int32),
        ("num_views", np.int32),
        ("num_agreeing", np.int32),
        ("weight", np.float32),
        ("place", np.float32, (3,)),
        ("colour", np.float32, (3,)),
    ]
)
"""A cell: the last view that saw it, its number of pixels, and the number of views; the maximum
number of views agreeing on a pixel; the sums over the views of weights, weighted positions in the
cell (in cells) and weighted colours."""

_NEAR_SQ = 0.25
"""Squared distance, in cells, below which a point counts as at the requested position."""
_REACHES = (1, 4)
"""Cells on each side searched for colours; no surface is farther from its points."""


class CellCloud:
    """Weighted means of the points in each cell of a grid.

    Parameters
    ----------
    cell : float
        Side of a cell, world units.
    """

    def __init__(self, cell: float) -> None:
        self.cell = cell
        self._table = CellTable(_CELL)
        self._num_views = 0

    def add(self, view: DepthMap) -> None:
        """Add the points of a view."""
        mask = view.valid_mask
        places = view.points(mask) / self.cell
        self._num_views += 1
        rows = self._rows_of(places)
        agreeing = np.ones(mask.shape, np.uint8) if view.num_views is None else view.num_views
        weights = 1.0 / view.sigma[mask] ** 2
        seen = places, weights, view.colours[mask], agreeing[mask]
        _add(self._table.rows, rows, *seen)

    def cloud(self) -> PointCloud:
        """The points (world), with sigma, and `views`: the number of views that agree on each."""
        cells = self._table.used
        weight = cells["weight"].astype(np.float64)[:, None]
        views = np.maximum(cells["num_views"], cells["num_agreeing"]).clip(0, 255)
        return PointCloud(
            points=(cells["index"] + cells["place"] / weight) * self.cell,
            colours=np.rint(cells["colour"] / weight).clip(0, 255).astype(np.uint8),
            sigma=1.0 / np.sqrt(weight[:, 0]),
            attributes={"views": views.astype(np.uint8)},
        )

    def colours_at(self, points: Array) -> NDArray[np.uint8]:
        """(N, 3) mean colours near points on the surface (N, 3), weighted by distance.

        A few cells around each point are searched, more if they are empty; black if all are.
        """
        places = points / self.cell
        sums = np.zeros((len(points), 4))
        for reach in _REACHES:
            lost = np.flatnonzero(sums[:, 3] == 0)
            sums[lost] = self._colour_sums(places[lost], reach)
        mean = sums[:, :3] / np.maximum(sums[:, 3:], 1e-12)
        colours: NDArray[np.uint8] = np.rint(mean).clip(0, 255).astype(np.uint8)
        return colours

    def _colour_sums(self, places: Array, reach: int) -> Array:
        """(N, 4) weighted sums of red, green and blue of the cells near points, and of weights."""
        index = np.floor(places).astype(np.int32)
        sums = np.zeros((len(places), 4))
        for step in product(range(-reach, reach + 1), repeat=3):
            rows = self._table.find(index + np.array(step, np.int32))
            near = np.flatnonzero(rows >= 0)
            cells = self._table.rows[rows[near]]
            means = cells["place"] / cells["weight"][:, None]
            away = cells["index"] + means - places[near]
            share = 1.0 / (_NEAR_SQ + (away**2).sum(axis=1))
            sums[near, :3] += cells["colour"] * share[:, None]
            sums[near, 3] += cells["weight"] * share
        return sums

    def _rows_of(self, places: Array) -> Numbers:
        """The row of each point's cell (N,), whose pixel count is updated."""
        rows = np.empty(len(places), np.int64)
        done = 0
        while done < len(places):
            done, num = _count(*self._table.arrays, places, self._num_views, done, rows)
            self._table.num_rows = num
            if self._table.is_full:
                self._table.grow()
        return rows


@njit(cache=True, nogil=True)
def _count(
    slots: Slots, cells: Rows, num: int, places: Array, view: int, first: int, rows: Numbers
) -> tuple[int, int]:
    """Count pixels in their cells until the table is full; return the next one and the cell count.

    Positions are in cells.
    """
    for k in range(first, len(places)):
        if num == len(cells):
            return k, num
        x, y, z = np.floor(places[k, 0]), np.floor(places[k, 1]), np.floor(places[k, 2])
        row, num = find_or_add(slots, cells, num, (int(x), int(y), int(z)))
        rows[k] = row
        cell = cells[row]
        if cell.last_view != view:
            cell.last_view = view
            cell.num_pixels = 0
            cell.num_views += 1
        cell.num_pixels += 1
    return len(places), num


@njit(cache=True, nogil=True)
def _add(
    cells: Rows,
    rows: Numbers,
    places: Array,
    weights: Floats,
    colours: NDArray[np.uint8],
    agreeing: NDArray[np.uint8],
) -> None:
    """Add pixels to their cells.

    Errors of one view are correlated: its pixels in a cell together weigh as much as one.
    """
    for k in range(len(rows)):
        cell = cells[rows[k]]
        weight = weights[k] / np.float32(cell.num_pixels)
        cell.weight += weight
        cell.num_agreeing = max(cell.num_agreeing, np.int32(agreeing[k]))
        for axis in range(3):
            place = np.float32(places[k, axis] - cell.index[axis])
            cell.place[axis] += weight * place
            cell.colour[axis] += weight * np.float32(colours[k, axis])
