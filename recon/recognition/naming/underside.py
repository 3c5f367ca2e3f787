"""The underside of level planes: a board has legs and air below it, a slice of a wall more wall."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.geometry import WORLD_UP
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Voxels

BELOW_CELLS, NEAR_CELLS = 1.25, 0.8
"""Depth below a cell, beyond the thickness of its plane, and how near to this place another cell
continues it downwards."""


def free_below(board: FlatPiece, cells: Voxels) -> float:
    """Share of a board's cells below which there is no other cell of the object."""
    size = cells.cell_size
    places: NDArray[np.float64] = cells.means[board.rows] - BELOW_CELLS * size * np.array(WORLD_UP)
    away, _ = cKDTree(cells.means).query(places, distance_upper_bound=NEAR_CELLS * size)
    return float(np.isinf(away).mean())
