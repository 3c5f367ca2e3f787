"""A view of a layer as an image, and the row of the layer at each pixel."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.app.filters import Shown
from recon.app.layers import Layer
from recon.app.looks import COLOUR, Look
from recon.app.orbit import Orbit
from recon.figures import scales
from recon.figures.solids import drawn_solids, triangles_of
from recon.records import FoundObject, Voxels
from recon.world.raster import Lens, Raster

SIZE = (960, 720)
"""Width and height of a view in pixels."""
LIGHT, DARK = (250, 250, 249), (24, 27, 31)
MARKED = np.array([255, 140, 0], np.uint8)
POINT_PX, LARGEST_POINT_PX = 2, 9
POINTS_SHARE = 0.01
"""Share of the view that few points fill, until they are of the largest size."""
SEE_THROUGH = 0.55
"""Opacity of a solid in front of its cells."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """A drawn view."""

    image: NDArray[np.uint8]
    """(H, W, 3)"""
    number: NDArray[np.int32]
    """(H, W) row of the layer under each pixel; -1 = none."""
    lens: Lens
    layer: Layer
    shown: Shown

    def row_at(self, column_px: float, row_px: float, reach_px: int = 3) -> int | None:
        """The row of the layer at a pixel, or the nearest within reach."""
        height, width = self.number.shape
        u, v = round(column_px), round(row_px)
        top, left = max(v - reach_px, 0), max(u - reach_px, 0)
        near = self.number[top : min(v + reach_px + 1, height), left : min(u + reach_px + 1, width)]
        rows, columns = np.nonzero(near >= 0)
        if not len(rows):
            return None
        nearest = np.argmin((rows + top - v) ** 2 + (columns + left - u) ** 2)
        return int(near[rows[nearest], columns[nearest]])


def draw(
    layer: Layer, shown: Shown, orbit: Orbit, look: Look, size: tuple[int, int] = SIZE
) -> View:
    """Draw the shown rows of a layer; quick views have full-resolution numbers, too."""
    drawn = (size[0] // 2, size[1] // 2) if look.is_quick else size
    raster = Raster(orbit.lens(*drawn), DARK if look.is_dark else LIGHT)
    _add_rows(raster, layer, shown, look)
    if look.solids and isinstance(layer.data, Voxels):
        _add_solids(raster, layer.data, look.solids)
    number = raster.number
    if look.is_quick:
        number = number.repeat(2, axis=0).repeat(2, axis=1)
    lens = orbit.lens(*size)
    return View(image=raster.image, number=number, lens=lens, layer=layer, shown=shown)


def _add_rows(raster: Raster, layer: Layer, shown: Shown, look: Look) -> None:
    """Add the cells, triangles or points of the layer."""
    colours = row_colours(layer, shown.rows, look)
    numbers = shown.rows.astype(np.int32)
    if isinstance(layer.data, Voxels) and layer.covered is not None:
        raster.add_cells(
            layer.data.index[shown.rows], layer.covered[shown.rows], colours, numbers,
            layer.data.cell_size,
        )  # fmt: skip
        raster.shade(20.0)
    elif layer.triangles is not None:
        _add_mesh(raster, layer, shown, look)
    else:
        side = point_side(len(shown.rows), raster.number.size)
        side = max(1, side // 2) if look.is_quick else side
        raster.add_points(layer.places[shown.rows], colours, numbers, side)
        raster.shade()


def point_side(num_points: int, num_pixels: int) -> int:
    """Side in pixels of the square of a point: larger if there are few."""
    side = math.sqrt(POINTS_SHARE * num_pixels / max(num_points, 1))
    return min(max(round(side), POINT_PX), LARGEST_POINT_PX)


def row_colours(layer: Layer, rows: NDArray[np.int64], look: Look) -> NDArray[np.uint8]:
    """Colours (M, 3) of rows: their own, or those of a column's values."""
    if look.colour_by == COLOUR or look.colour_by not in layer.columns:
        colours = layer.colours[rows].copy()
    else:
        values = layer.columns[look.colour_by]
        scale = scales.coloured(values, scales.COUNT)
        colours = scales.rgb(scale, np.nan_to_num(values[rows], nan=scale.get_clim()[0]))
    if look.selected is not None and "object" in layer.columns:
        colours[layer.columns["object"][rows] == look.selected] = MARKED
    return np.ascontiguousarray(colours)


def _add_mesh(raster: Raster, layer: Layer, shown: Shown, look: Look) -> None:
    """Add the triangles whose corners are all shown, with a corner for clicks."""
    assert layer.triangles is not None
    every = np.arange(len(layer))
    is_shown = np.zeros(len(layer), bool)
    is_shown[shown.rows] = True
    kept = layer.triangles[is_shown[layer.triangles].all(axis=1)]
    raster.add_triangles(layer.places, kept, row_colours(layer, every, look), kept[:, 0].copy())


def _add_solids(raster: Raster, voxels: Voxels, objects: tuple[FoundObject, ...]) -> None:
    over = Raster(raster.lens, (0, 0, 0))
    for found in objects:
        for one in drawn_solids(voxels, found):
            vertices, triangles = triangles_of(one.solid)
            colours = np.tile(np.array(one.colour, np.uint8), (len(vertices), 1))
            over.add_triangles(vertices, triangles, colours, np.zeros(len(triangles), np.int32))
    # A solid intersects its cells: it is visible slightly behind them, too.
    depth = 1.15 * over.inverse_depth
    before = (over.number >= 0) & (depth >= raster.inverse_depth)
    mixed = SEE_THROUGH * over.image[before] + (1.0 - SEE_THROUGH) * raster.image[before]
    raster.image[before] = mixed.astype(np.uint8)
