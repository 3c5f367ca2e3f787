"""The underside of level planes: a board has legs and air below it, a slice of a wall more wall."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.geometry import WORLD_UP
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Voxels

BESIDE_CELLS, NEAR_CELLS = 1.25, 0.8
"""Distance from a cell, beyond the thickness of its plane, and how near to this place another cell
continues it."""
FULL = 0.5
"""Share of the usual number of points from which a cell continues it: noise beside thin legs has
fewer, and closes nothing."""


def free_below(board: FlatPiece, cells: Voxels) -> float:
    """Share of a board's cells with no other full cell of the object below them.

    Nothing is known of what is lower than its lowest cell: there it must be free above.
    """
    means: NDArray[np.float64] = cells.means[board.rows]
    step = BESIDE_CELLS * cells.cell_size * np.array(WORLD_UP)
    full = cells.means[cells.counts >= FULL * np.median(cells.counts)]
    tree, reach = cKDTree(full), NEAR_CELLS * cells.cell_size
    above, below = (
        np.isinf(tree.query(means + side, distance_upper_bound=reach)[0]) for side in (step, -step)
    )
    is_low = (means - step)[:, 1] < cells.means[:, 1].min()
    return float(np.where(is_low, above, below).mean())
