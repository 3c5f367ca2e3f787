"""Columns: the occupied cells of the map above the ground, by the floor cell they stand on."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array, Floor, Mask
from recon.records import Voxels, cell_centres
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import RULES, occupied


@dataclass(slots=True, kw_only=True, eq=False)
class Columns:
    """The occupied cells above the ground, looked at again only where a pair has points."""

    voxel_map: VoxelMap
    settings: MapSettings
    floor: Floor
    """Its cells are as large as those of the map."""
    ground: float
    """Minimum height of the centre of a cell, world units."""
    under: Mask = field(init=False)
    """(X, Z) floor cells with an occupied cell above them."""
    number: NDArray[np.intp] = field(init=False)
    """(X, Z) number of occupied cells above each floor cell."""

    def __post_init__(self) -> None:
        self.under = np.zeros(self.floor.shape, dtype=np.bool_)
        self.number = np.zeros(self.floor.shape, dtype=np.intp)

    def update(self, points: Array) -> Mask:
        """Look at the map again after points (N, 3) were added.

        Returns
        -------
        (X, Z) bool
            Floor cells above which the map may have changed.
        """
        touched = self._touched(points)
        below = self._below(self.over(touched).centres)
        number = np.bincount(below, minlength=touched.size).reshape(touched.shape)
        self.number[touched] = number[touched]
        self.under[touched] = number[touched] > 0
        return touched

    def over(self, cells: Mask) -> Voxels:
        """The occupied cells of the map above some floor cells (X, Z)."""
        chosen = np.append(cells.ravel(), False)

        def is_over(index: NDArray[np.integer]) -> Mask:
            centres = cell_centres(index, self.floor.cell_size)
            standing: Mask = centres[:, 1] >= self.ground
            standing[standing] = chosen[self._below(centres[standing])]
            return standing

        return occupied(self.voxel_map, self.settings, is_over)

    def _touched(self, points: Array) -> Mask:
        """Floor cells (X, Z) below map cells that points (N, 3) may have changed."""
        if any("rays" in RULES[rule].channels for rule in self.settings.occupancy):
            return np.ones(self.floor.shape, dtype=np.bool_)
        index = np.floor(points / self.floor.cell_size)
        return self.floor.mask((index[:, [0, 2]] + 0.5) * self.floor.cell_size)

    def _below(self, centres: Array) -> NDArray[np.intp]:
        """Flat index (N,) of the floor cell below each point (N, 3)."""
        return self.floor.flat(self.floor.cells(centres[:, [0, 2]]))

    def number_of(self, voxels: Voxels, number: NDArray[np.intp]) -> NDArray[np.intp]:
        """The numbers, of those on the floor (X, Z), below some cells of the map; -1 = off it."""
        numbers: NDArray[np.intp] = np.append(number.ravel(), -1)[self._below(voxels.centres)]
        return numbers
