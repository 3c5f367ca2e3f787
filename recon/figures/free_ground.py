"""Free, occupied and unknown floor of a map without rays: seen ground is free."""

import numpy as np
from numpy.typing import NDArray

from recon.geometry import transform
from recon.recognition.segments.ground import level_plane
from recon.records import GroundGrid, Voxels
from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN

THICKNESS_CELLS = 2.0
"""Cells so far above the ground are part of it: it is neither smooth nor measured exactly."""


def states_by_ground(voxels: Voxels) -> GroundGrid | None:
    """States (NX, NZ) of floor cells: OCCUPIED where something stands on the ground, FREE where
    ground is seen and nothing on it, else UNKNOWN. None where the map shows no ground.
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
