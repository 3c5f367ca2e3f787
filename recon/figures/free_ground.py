"""Free, occupied and unknown floor of a map without rays: visible ground is free."""

import numpy as np
from numpy.typing import NDArray

from recon.geometry import transform
from recon.recognition.segments.ground import level_plane
from recon.records import GroundGrid, Voxels
from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN

THICKNESS_CELLS = 2.0
"""Height up to which cells belong to the ground, which is neither smooth nor exactly measured."""


def states_by_ground(voxels: Voxels) -> GroundGrid | None:
    """States (NX, NZ) of floor cells; None if the map shows no ground.

    OCCUPIED below obstacles, FREE where ground is visible without obstacles, else UNKNOWN.
    """
    T_floor_world = level_plane(voxels.means)
    if T_floor_world is None:
        return None
    height = transform(T_floor_world, voxels.means)[:, 1]
    places = voxels.index[:, [0, 2]]
    low = places.min(axis=0)
    cells = np.full(np.ptp(places, axis=0) + 1, UNKNOWN, np.int8)
    stands = height > THICKNESS_CELLS * voxels.cell_size
    for chosen, state in ((~stands, FREE), (stands, OCCUPIED)):
        x, z = (places[chosen] - low).T
        cells[x, z] = state
    origin: NDArray[np.float64] = low.astype(np.float64) * voxels.cell_size
    return GroundGrid(cells=cells, origin_xz=origin, cell_size=voxels.cell_size)
