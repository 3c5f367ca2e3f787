"""Cuts through the map at several heights, each cell in its own colour."""

from typing import Any

import numpy as np

from recon.figures.canvas import Image, Size, new_axes, new_figure, to_image
from recon.records import Voxels

SIZE: Size = (1200, 820)
NUM_SLICES = 6


def slices(voxels: Voxels, size: Size = SIZE) -> Image:
    """Layers of cells at `NUM_SLICES` heights, evenly spread, seen from above."""
    figure = new_figure(size)
    layers = np.unique(voxels.index[:, 1])
    picked = layers[np.linspace(0, len(layers) - 1, min(NUM_SLICES, len(layers))).astype(int)]
    for number, layer in enumerate(picked):
        low, high = np.array([layer, layer + 1]) * voxels.cell_size
        title = f"y = {low:g} to {high:g}"
        axes = new_axes(figure, title, at=(2, (NUM_SLICES + 1) // 2, number + 1))
        _draw_layer(axes, voxels, layer)
    return to_image(figure)


def _draw_layer(axes: Any, voxels: Voxels, layer: int) -> None:
    floor = voxels.index[:, [0, 2]]
    low = floor.min(axis=0)
    width, depth = floor.max(axis=0) - low + 1
    sheet = np.full((depth, width, 3), 255, dtype=np.uint8)
    here = voxels.index[:, 1] == layer
    x, z = (floor[here] - low).T
    sheet[z, x] = voxels.colours[here]
    left, top = low * voxels.cell_size
    cell = voxels.cell_size
    axes.imshow(sheet, extent=(left, left + width * cell, top + depth * cell, top))
