"""Cuts through the map at several heights, each cell in its own colour."""

from typing import Any

import numpy as np

from recon.figures import floor
from recon.figures.canvas import Sheet, Size
from recon.figures.map3d import UNITS
from recon.records import GroundGrid, Voxels

SIZE: Size = (1200, 820)
NUM_SLICES = 6


def slices(voxels: Voxels, *, unit: str = UNITS, sheet: Sheet | None = None) -> Any:
    """Layers of cells at `NUM_SLICES` heights, evenly spread over the cells, seen from above."""
    sheet = sheet or Sheet.of(SIZE)
    # Most cells lie in between; layers with a few outliers would be nearly empty.
    places = np.linspace(0.02, 0.98, NUM_SLICES)
    heights = np.quantile(voxels.index[:, 1], places) if len(voxels) else np.zeros(0)
    layers = np.unique(heights.astype(int))
    if not len(layers):
        sheet.axes("no cells", xlabel=f"x [{unit}]", ylabel=f"z [{unit}]")
    columns = max(-(-len(layers) // 2), 1)
    rows = min(len(layers), 2) or 1
    for number, layer in enumerate(layers):
        low, high = np.array([layer, layer + 1]) * voxels.cell_size
        axes = sheet.axes(
            f"y = {low:.4g} to {high:.4g} {unit}", at=(rows, columns, number + 1),
            xlabel=f"x [{unit}]" if number >= len(layers) - columns else "",
            ylabel=f"z [{unit}]" if number % columns == 0 else "",
        )  # fmt: skip
        axes.set_aspect("equal")
        _draw_layer(axes, voxels, int(layer))
        floor.show(axes, floor.extent_of(voxels))
    return sheet.figure


def _draw_layer(axes: Any, voxels: Voxels, layer: int) -> None:
    places = voxels.index[:, [0, 2]]
    low = places.min(axis=0)
    width, depth = places.max(axis=0) - low + 1
    colours = np.full((width, depth, 4), 0, dtype=np.uint8)
    here = voxels.index[:, 1] == layer
    x, z = (places[here] - low).T
    colours[x, z, :3] = voxels.shown_colours[here]
    colours[x, z, 3] = 255
    origin = low.astype(np.float64) * voxels.cell_size
    grid = GroundGrid(cells=colours, origin_xz=origin, cell_size=voxels.cell_size)
    floor.draw_grid(axes, grid, colours)
