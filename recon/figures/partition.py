"""Whose cells are whose: those of an object, and of each of its parts."""

import colorsys

import numpy as np
from numpy.typing import NDArray

from recon.records import FoundObject, Voxels

MARGIN_CELLS = 1.0
"""Cells so far outside the box of an object still belong to it."""
GREY = (138, 138, 138)
RGB = tuple[int, int, int]


def cells_of_mask(voxels: Voxels, found: FoundObject) -> NDArray[np.bool_]:
    """(K,) whether a cell lies in the box of an object."""
    reach = found.size / 2.0 + MARGIN_CELLS * voxels.cell_size
    away = np.abs(voxels.means - found.centre)
    inside: NDArray[np.bool_] = np.all(away <= reach, axis=1)
    return inside


def cells_of(voxels: Voxels, found: FoundObject) -> Voxels:
    """The cells in the box of an object."""
    return voxels.select(np.flatnonzero(cells_of_mask(voxels, found)))


def nearest_part(voxels: Voxels, found: FoundObject) -> NDArray[np.intp]:
    """(K,) number of the part whose surface is the nearest."""
    distances = [part.solid.distances(voxels.means) for part in found.parts]
    nearest: NDArray[np.intp] = np.argmin(distances, axis=0)
    return nearest


def part_colour(voxels: Voxels, found: FoundObject, number: int) -> RGB:
    """The middle colour of a part's own cells; where it has none, that of its hue."""
    own = cells_of(voxels, found)
    own = own.select(nearest_part(own, found) == number)
    hue = found.parts[number].hue_deg
    if len(own):
        red, green, blue = np.median(own.colours, axis=0).astype(int).tolist()
        return red, green, blue
    if hue is None:
        return GREY
    red, green, blue = (round(255 * share) for share in colorsys.hsv_to_rgb(hue / 360, 0.7, 0.75))
    return red, green, blue


def by_hue(voxels: Voxels) -> NDArray[np.uint8]:
    """Colours (K, 3) that show nothing but the hue; grey where there is none."""
    rgb = voxels.colours / 255.0
    hsv = [colorsys.rgb_to_hsv(*row) for row in rgb.tolist()]
    pure = [colorsys.hsv_to_rgb(h, min(1.0, 2.0 * s), 0.85) for h, s, _ in hsv]
    return np.rint(255.0 * np.array(pure).reshape(-1, 3)).astype(np.uint8)
