"""Points and cells by owner: those of an object, and of each of its parts."""

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from recon.records import FoundObject, Voxels

MARGIN_CELLS = 1.0
"""Distance outside the box of an object up to which cells still belong to it."""
NO_OBJECT = -1.0
GREY = (138, 138, 138)
NUM_HUES = 18
RGB = tuple[int, int, int]


def owners(
    points: NDArray[np.float64], objects: Sequence[FoundObject], cell_size: float
) -> NDArray[np.float64]:
    """(N,) id of the object whose box contains each point (N, 3); of several, the smallest.

    NO_OBJECT where there is none.
    """
    ids = np.full(len(points), NO_OBJECT)
    for found in sorted(objects, key=lambda one: -float(np.prod(one.size))):
        ids[_is_in_box(points, found, cell_size)] = found.id
    return ids


def cells_of(voxels: Voxels, found: FoundObject) -> Voxels:
    """The cells in the box of an object."""
    is_own = _is_in_box(voxels.means, found, voxels.cell_size)
    return voxels.select(np.flatnonzero(is_own))


def _is_in_box(
    points: NDArray[np.float64], found: FoundObject, cell_size: float
) -> NDArray[np.bool_]:
    reach = found.size / 2.0 + MARGIN_CELLS * cell_size
    inside: NDArray[np.bool_] = np.all(np.abs(points - found.centre) <= reach, axis=1)
    return inside


@dataclass(frozen=True, kw_only=True, eq=False)
class PartCells:
    """The cells of an object, and how far each is from each part."""

    found: FoundObject
    cells: Voxels
    distances: NDArray[np.float64]
    """(P, K) of the means of the cells from the surfaces of the parts."""

    @classmethod
    def of(cls, voxels: Voxels, found: FoundObject) -> "PartCells":
        """The cells of a map in the box of an object."""
        cells = cells_of(voxels, found)
        shape = len(found.parts), len(cells)
        distances = [part.solid.distances(cells.means) for part in found.parts]
        return cls(found=found, cells=cells, distances=np.reshape(distances, shape))

    def own(self, number: int) -> Voxels:
        """The cells nearest to a part."""
        return self.cells.select(self._rows(number))

    @cached_property
    def _nearest(self) -> NDArray[np.intp]:
        """(K,) numbers of the parts with the nearest surfaces."""
        nearest: NDArray[np.intp] = np.argmin(self.distances, axis=0)
        return nearest

    def _rows(self, number: int) -> NDArray[np.intp]:
        return np.flatnonzero(self._nearest == number)

    def colour(self, number: int) -> RGB:
        """The median colour of a part's own cells; if it has none, that of its hue."""
        own = self.cells.select(self._inner_rows(number))
        hue = self.found.parts[number].hue_deg
        if len(own):
            red, green, blue = np.median(_of_one_hue(own.shown_colours), axis=0).astype(int)
            return int(red), int(green), int(blue)
        if hue is None:
            return GREY
        shares = colorsys.hsv_to_rgb(hue / 360, 0.7, 0.75)
        red, green, blue = (round(255 * share) for share in shares)
        return red, green, blue

    def _inner_rows(self, number: int) -> NDArray[np.intp]:
        """The rows of a part; if it has neighbours, the half that is farther from them."""
        rows = self._rows(number)
        others = np.delete(self.distances[:, rows], number, axis=0)
        if not others.size:
            return rows
        away = others.min(axis=0)
        inner: NDArray[np.intp] = rows[away >= np.median(away)]
        return inner


def _of_one_hue(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The colours (M, 3) around the most common hue: the mean of two hues would be neither."""
    hues = np.array([colorsys.rgb_to_hsv(*row)[0] for row in (colours / 255.0).tolist()])
    counts = np.bincount((hues * NUM_HUES).astype(int) % NUM_HUES, minlength=NUM_HUES)
    smooth = counts + np.roll(counts, 1) + np.roll(counts, -1)
    middle = (np.argmax(smooth) + 0.5) / NUM_HUES
    away = np.abs((hues - middle + 0.5) % 1.0 - 0.5)
    chosen: NDArray[np.uint8] = colours[away <= 1.5 / NUM_HUES]
    return chosen


def by_hue(voxels: Voxels) -> NDArray[np.uint8]:
    """Colours (K, 3) that show only the hue; grey where there is none."""
    rgb = voxels.shown_colours / 255.0
    hsv = [colorsys.rgb_to_hsv(*row) for row in rgb.tolist()]
    pure = [colorsys.hsv_to_rgb(h, min(1.0, 2.0 * s), 0.85) for h, s, _ in hsv]
    return np.rint(255.0 * np.array(pure).reshape(-1, 3)).astype(np.uint8)
