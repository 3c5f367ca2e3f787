"""The dense cloud of many views: one point per cell, with a sigma from its views."""

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.records import PointCloud
from recon.surface.depth import DepthMap
from recon.surface.pages import Pages, page_path, read_page, regions_of, saved_keys
from recon.voxelmap.table import CellTable, Rows, Slots, find_row

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

CELL = np.dtype(
    [
        ("index", np.int32, (3,)),
        ("last_view", np.int32),
        ("num_pixels", np.int32),
        ("num_views", np.int32),
        ("num_agreeing", np.int32),
        ("weight", np.int64),
        ("place", np.int64, (3,)),
        ("colour", np.int64, (3,)),
    ]
)
"""A cell: the last view that saw it, its number of pixels, and the number of views; the maximum
number of views agreeing on a pixel; the sums over the views of weights, weighted positions in the
cell (in cells) and weighted colours."""

_UNITS = 1 << 24
"""Resolution of weights; integer sums do not depend on the order of the views."""
_SUREST = 2.0**-10
"""Minimum sigma of a point, in cells; bounds its weight."""
_REGION = 128
"""Cells along each side of a region."""
_NEAR_SQ = 0.25
"""Squared distance, in cells, below which a point counts as at the requested position."""
_REACHES = (1, 4)
"""Cells on each side searched for colours; no surface is farther from its points."""


class _Pixels(NamedTuple):
    """The known pixels of a view."""

    places: Array
    """(N, 3) in cells."""
    weights: Array
    """(N,) inverse variances."""
    colours: NDArray[np.uint8]
    """(N, 3) RGB."""
    agreeing: NDArray[np.uint8]
    """(N,) number of views that agree, including this one."""


class CellCloud:
    """Weighted means of the points in each cell of a grid.

    The result does not depend on the order of the views.

    Parameters
    ----------
    cell : float
        Side of a cell, world units.
    folder : Path, optional
        Folder for regions out of use, which bounds memory; all stay in memory if None.
    """

    def __init__(self, cell: float, folder: Path | None = None) -> None:
        self.cell = cell
        self.pages = Pages(CELL, _REGION, folder)
        self._num_views = 0

    def add(self, view: DepthMap) -> None:
        """Add the points of a view."""
        mask = view.valid_mask
        places = view.points(mask) / self.cell
        sigma = np.maximum(view.sigma[mask] / self.cell, _SUREST)
        agreeing = np.ones(mask.shape, np.uint8) if view.num_views is None else view.num_views
        seen = _Pixels(places, _UNITS / sigma**2, view.colours[mask], agreeing[mask])
        self._num_views += 1
        index = np.floor(places).astype(np.int32)
        for key, pixels in regions_of(index, _REGION):
            table = self.pages.page(key)
            rows = table.enter(index[pixels])
            _add(table.rows, rows, self._num_views, pixels, seen)

    def merge(self, folder: Path) -> None:
        """Add the saved pages of another cloud, of other views."""
        for key in saved_keys(folder):
            other = read_page(page_path(folder, key), CELL)
            table = self.pages.page(key)
            rows = table.enter(other["index"])
            for name in ("num_views", "weight", "place", "colour"):
                table.rows[name][rows] += other[name]
            most = np.maximum(table.rows["num_agreeing"][rows], other["num_agreeing"])
            table.rows["num_agreeing"][rows] = most

    def __len__(self) -> int:
        return self.pages.num_cells

    def __iter__(self) -> Iterator[PointCloud]:
        """Yield the points (world) by region, at least once.

        They have a sigma, and `views`: the number of views that agree on each.
        """
        return map(self._points, chain([np.zeros(0, CELL)], self.pages))

    def _points(self, cells: Rows) -> PointCloud:
        weight = cells["weight"].astype(np.float64)[:, None]
        views = np.maximum(cells["num_views"], cells["num_agreeing"]).clip(0, 255)
        return PointCloud(
            points=(cells["index"] + cells["place"] / weight) * self.cell,
            colours=np.rint(cells["colour"] / weight).clip(0, 255).astype(np.uint8),
            sigma=self.cell * np.sqrt(_UNITS / weight[:, 0]),
            attributes={"views": views.astype(np.uint8)},
        )

    def colours_at(self, points: Array) -> NDArray[np.uint8]:
        """(N, 3) mean colours near points on the surface (N, 3), weighted by distance.

        A few cells around each point are searched, more if they are empty; black if all are.
        """
        places = points / self.cell
        colours = np.zeros((len(points), 3), np.uint8)
        for key, chosen in regions_of(np.floor(places).astype(np.int32), _REGION):
            cells = self.pages.around(key, max(_REACHES))
            colours[chosen] = _colours(cells, places[chosen])
        return colours


def joined(parts: Iterable[PointCloud]) -> PointCloud:
    """The points of one or more parts of a dense cloud, in one."""
    clouds = list(parts)
    views = np.concatenate([part.attributes["views"] for part in clouds])
    return PointCloud(
        points=np.concatenate([part.points for part in clouds]),
        colours=np.concatenate([part.shown_colours for part in clouds]),
        sigma=np.concatenate([part.sigma for part in clouds if part.sigma is not None]),
        attributes={"views": views},
    )


def _colours(cells: CellTable, places: Array) -> NDArray[np.uint8]:
    sums = np.zeros((len(places), 4))
    for reach in _REACHES:
        _add_colours(cells.slots, cells.rows, places, reach, sums)
    mean = sums[:, :3] / np.maximum(sums[:, 3:], 1e-12)
    colours: NDArray[np.uint8] = np.rint(mean).clip(0, 255).astype(np.uint8)
    return colours


@njit(cache=True, nogil=True)
def _add_colours(slots: Slots, cells: Rows, places: Array, reach: int, sums: Array) -> None:
    """Add up the cells near each point without a sum: red, green, blue and weight (N, 4)."""
    for k in range(len(places)):
        if sums[k, 3] > 0:
            continue
        x, y, z = np.floor(places[k, 0]), np.floor(places[k, 1]), np.floor(places[k, 2])
        for step in range((2 * reach + 1) ** 3):
            i, j, m = _step(step, reach)
            row = find_row(slots, cells, (int(x) + i, int(y) + j, int(z) + m))
            if row >= 0:
                _add_colour(cells[row], places[k], sums[k])


@njit(cache=True, nogil=True)
def _step(number: int, reach: int) -> tuple[int, int, int]:
    """Offset of a cell in the cube around a middle one."""
    side = 2 * reach + 1
    return number // side**2 - reach, number // side % side - reach, number % side - reach


@njit(cache=True, nogil=True)
def _add_colour(cell: Any, place: Array, sums: Array) -> None:
    away_sq = 0.0
    for axis in range(3):
        away_sq += (cell.index[axis] + cell.place[axis] / cell.weight - place[axis]) ** 2
    share = 1.0 / (_NEAR_SQ + away_sq)
    for channel in range(3):
        sums[channel] += cell.colour[channel] * share
    sums[3] += cell.weight * share


@njit(cache=True, nogil=True)
def _add(
    cells: Rows,
    rows: Numbers,
    view: int,
    pixels: Numbers,
    seen: _Pixels,
) -> None:
    """Add some pixels of a view to their cells, given by their rows.

    Errors of one view are correlated: its pixels in a cell together weigh as much as one.
    """
    for row in rows:
        cell = cells[row]
        if cell.last_view != view:
            cell.last_view = view
            cell.num_pixels = 0
            cell.num_views += 1
        cell.num_pixels += 1
    for row, k in zip(rows, pixels):  # noqa: B905 - not known to the compiler
        cell = cells[row]
        weight = max(np.floor(seen.weights[k] / cell.num_pixels + 0.5), 1.0)
        cell.weight += np.int64(weight)
        cell.num_agreeing = max(cell.num_agreeing, np.int32(seen.agreeing[k]))
        for axis in range(3):
            place = seen.places[k, axis] - cell.index[axis]
            cell.place[axis] += np.int64(np.floor(weight * place + 0.5))
            cell.colour[axis] += np.int64(weight) * np.int64(seen.colours[k, axis])
