"""Planes of no kind, which compete with parts on one axis: a box on a box is not a cottage."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from recon.recognition.naming.assembly import bic_of_pieces
from recon.recognition.naming.case import Case
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Plane, Voxels

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_PLANES = 2
"""Minimum number of planes that compete: a single one is a solid, which competes anyway."""
MOST_INSIDE, LEAST_FREE = 0.15, 0.3
"""Share of a plane's cells with other cells on all sides, and least share of those with none on one
side of the plane, from which it is a slice of something thick."""
BESIDE_CELLS, NEAR_CELLS = 1.25, 0.8
"""Distance from a cell to what is beside it, and how near to this place another cell is."""
AXES = np.eye(3)


def flat_rival(case: Case) -> float:
    """BIC per cell of planes of no kind, minus that of a formless object; 0 if these are too few.

    Noise wider than a cell fills an object with cells, whose means then lie in layers along the
    axes of the map: each explains its cells, and is only a slice of the object.
    """
    planes = case.faces.planes
    if len(planes) < LEAST_PLANES:
        return 0.0
    inside = np.all([_are_between(case.dense, axis) for axis in AXES], axis=0)
    faces = [one for one in planes if not _is_slice(one, inside, case.dense)]
    if len(faces) < LEAST_PLANES:
        return 0.0
    return case.dense_criterion(bic_of_pieces(case.dense, faces))


def _is_slice(plane: FlatPiece, inside: Mask, cells: Voxels) -> bool:
    """True if a plane is not the outer side of its object."""
    if inside[plane.rows].mean() < MOST_INSIDE or not isinstance(plane.solid, Plane):
        return False
    between = _are_between(cells, plane.solid.normal)[plane.rows]
    return bool(1.0 - between.mean() < LEAST_FREE)


def _are_between(cells: Voxels, direction: Array) -> Mask:
    """Mask (N,) of the cells with others on both sides along a direction."""
    tree, reach = cKDTree(cells.means), NEAR_CELLS * cells.cell_size
    step = BESIDE_CELLS * cells.cell_size * direction
    sides = np.stack([cells.means + step, cells.means - step])
    away = np.asarray(tree.query(sides, distance_upper_bound=reach)[0])
    between: Mask = np.isfinite(away).all(axis=0)
    return between
