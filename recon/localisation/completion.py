"""Completion: the cells of a map, and the unseen sides of its objects by the solids fitted to them.

A map seldom shows an object from all sides; its solids say where the others are.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.recognition.cells import distinct, means
from recon.recognition.fitting.surface_points import area, surface
from recon.records import FoundObject, Plane, Solid, Voxels

Array = NDArray[np.float64]

PER_CELL = 2.0
"""Points drawn on a solid per area of a cell's face."""


def completed(voxels: Voxels, objects: tuple[FoundObject, ...]) -> Array:
    """Points (K, 3) on all surfaces of a map, one per cell."""
    solids = [_bounded(one) for one in objects]
    unseen = [_drawn(some, voxels.cell_size) for some in solids if some]
    return thinned(np.concatenate([voxels.means.reshape(-1, 3), *unseen]), voxels.cell_size)


def _bounded(one: FoundObject) -> list[Solid]:
    """The solids of an object that end where it may end."""
    solids = [part.solid for part in one.parts]
    return [solid for solid in solids if not isinstance(solid, Plane) and one.holds(solid)]


def thinned(points: Array, side: float) -> Array:
    """The means (K, 3) of the points in each cube of a grid."""
    return means(points, distinct(np.floor(points / side).astype(np.int64))[1])


def _drawn(solids: Sequence[Solid], cell_size: float) -> Array:
    whole = sum(area(solid) for solid in solids)
    number = int(PER_CELL * whole / cell_size**2) + len(solids)
    return surface(solids, number, np.random.default_rng(0)).points
