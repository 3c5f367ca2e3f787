"""Objects taken apart (thesis figures 28, 29): the cells by hue, then every part by itself."""

import colorsys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.figures.canvas import INK, Image, Size, new_figure, to_image
from recon.figures.map3d import map3d
from recon.records import UNKNOWN, FoundObject, Voxels

SIZE: Size = (1200, 1050)
MARGIN_CELLS = 1.0
"""Cells so far outside the box of an object still belong to it."""


def parts(voxels: Voxels, objects: Sequence[FoundObject], size: Size = SIZE) -> Image:
    """One row for the largest object of every label: its hues, then its parts."""
    chosen = largest_of_each(objects)
    columns = 1 + max((len(found.parts) for found in chosen), default=0)
    tile = size[0] // columns, size[1] // max(len(chosen), 1)
    figure = new_figure(size)
    for row, found in enumerate(chosen):
        cells = cells_of(voxels, found)
        nearest = nearest_part(cells, found)
        drawn = [(f"{found.label}: hue", map3d(cells, size=tile, colours=by_hue(cells)))]
        for number, part in enumerate(found.parts):
            own = cells.select(nearest == number)
            drawn.append((f"{part.role}: {part.solid.kind}", map3d(own, size=tile)))
        for column, (title, image) in enumerate(drawn):
            axes = figure.add_subplot(len(chosen), columns, 1 + row * columns + column)
            axes.imshow(image)
            axes.set_axis_off()
            axes.set_title(title, color=INK, fontsize=11, loc="left")
    return to_image(figure)


def largest_of_each(objects: Sequence[FoundObject]) -> list[FoundObject]:
    """For every label, by name, the object with the most cells."""
    named = sorted(objects, key=lambda found: (found.label, found.num_voxels))
    return list({found.label: found for found in named if found.label != UNKNOWN}.values())


def cells_of(voxels: Voxels, found: FoundObject) -> Voxels:
    """The cells in the box of an object."""
    reach = found.size / 2.0 + MARGIN_CELLS * voxels.cell_size
    outside = np.abs(voxels.means - found.centre) > reach
    return voxels.select(np.flatnonzero(~outside.any(axis=1)))


def nearest_part(voxels: Voxels, found: FoundObject) -> NDArray[np.intp]:
    """(K,) number of the part whose surface is the nearest."""
    distances = [part.solid.distances(voxels.means) for part in found.parts]
    nearest: NDArray[np.intp] = np.argmin(distances, axis=0)
    return nearest


def by_hue(voxels: Voxels) -> NDArray[np.uint8]:
    """Colours (K, 3) that show nothing but the hue; grey where there is none."""
    rgb = voxels.colours / 255.0
    hsv = [colorsys.rgb_to_hsv(*row) for row in rgb.tolist()]
    pure = [colorsys.hsv_to_rgb(h, min(1.0, 2.0 * s), 0.85) for h, s, _ in hsv]
    return np.rint(255.0 * np.array(pure).reshape(-1, 3)).astype(np.uint8)
