"""The floor seen from above: obstacles and free space."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import GroundGrid, Voxels

if TYPE_CHECKING:
    from recon.voxelmap.rays import Sightings

UNKNOWN, FREE, OCCUPIED = -1, 0, 1
"""States of a floor cell."""

BAND = (0.5, 6.0)
"""Lowest and highest obstacle of a robot of the thesis's worlds, world units."""

MAX_CELLS = 1 << 28
"""Maximum number of floor cells: a single far outlier must not exhaust the memory."""


def height_sum(voxels: Voxels) -> GroundGrid:
    """The thesis's 2D occupancy (section 4.4): counts summed over all heights, (NX, NZ) int64."""
    low, shape = _floor(voxels.index)
    cells = np.zeros(shape, np.int64)
    x, z = (voxels.index[:, [0, 2]] - low).T
    np.add.at(cells, (x, z), voxels.counts)
    return _grid(cells, low, voxels.cell_size)


def navigation(
    voxels: Voxels, sightings: "Sightings", band: tuple[float, float] = BAND
) -> GroundGrid:
    """Free, occupied and unknown floor cells (NX, NZ) int8: FREE, OCCUPIED or UNKNOWN.

    Parameters
    ----------
    voxels : Voxels
        The occupied cells.
    sightings : Sightings
        Cells that scans hit and passed.
    band : (low, high)
        Range of relevant heights, world units: cells whose centre is lower or higher count neither
        as obstacles nor as free space.
    """
    low_y, high_y = band
    if not low_y < high_y:
        raise InputError(f"band is {band}, but a lower and a higher height are needed")
    solid = _in_band(voxels.index, voxels.cell_size, band)
    clear = _in_band(sightings.index[sightings.passes > 0], voxels.cell_size, band)
    low, shape = _floor(np.concatenate([solid, clear]))
    cells = np.full(shape, UNKNOWN, np.int8)
    # A floor cell is free if a ray passed through one of its heights and none is occupied.
    for index, state in ((clear, FREE), (solid, OCCUPIED)):
        x, z = (index[:, [0, 2]] - low).T
        cells[x, z] = state
    return _grid(cells, low, voxels.cell_size)


def _in_band(
    index: NDArray[np.int64], cell_size: float, band: tuple[float, float]
) -> NDArray[np.int64]:
    middle = (index[:, 1] + 0.5) * cell_size
    return index[(middle >= band[0]) & (middle <= band[1])]


def _floor(index: NDArray[np.int64]) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """Lowest cell along x and z, and the number of cells along each."""
    if not len(index):
        return np.zeros(2, np.int64), (0, 0)
    floor = index[:, [0, 2]]
    low = floor.min(axis=0)
    num_x, num_z = (floor.max(axis=0) - low + 1).tolist()
    if num_x * num_z > MAX_CELLS:
        raise InputError(
            f"the floor has {num_x} x {num_z} cells, but at most {MAX_CELLS} are allowed"
        )
    return low, (num_x, num_z)


def _grid(cells: NDArray[np.generic], low: NDArray[np.int64], cell_size: float) -> GroundGrid:
    return GroundGrid(
        cells=cells, origin_xz=low.astype(np.float64) * cell_size, cell_size=cell_size
    )
