"""The faces of occupied cells that no other occupied cell covers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.records import Voxels
from recon.voxelmap.table import CellTable

# Corners of the six faces of a unit cell, counter-clockwise seen from outside.
_DIRECTIONS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]])
_CORNERS = np.array(
    [
        [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]],
        [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]],
        [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
        [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]],
        [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    ]
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Faces:
    """Squares in space, each with the colour of its cell."""

    vertices: NDArray[np.float64]
    """(Q, 4, 3) corners, world, counter-clockwise seen from outside the cell."""
    colours: NDArray[np.uint8]
    """(Q, 3) RGB."""
    cell: NDArray[np.int64]
    """(Q,) the row of the cell in the voxels."""

    def __len__(self) -> int:
        return len(self.vertices)


def covered_faces(voxels: Voxels) -> NDArray[np.uint8]:
    """(K,) six bits: bit f is set where face f (-x, +x, -y, +y, -z, +z) has a neighbour cell."""
    rows = np.zeros(len(voxels), [("index", "i4", 3)])
    rows["index"] = voxels.index
    table = CellTable.of(rows)
    bits = np.zeros(len(voxels), np.uint8)
    for face, direction in enumerate(_DIRECTIONS):
        bits |= (table.find(voxels.index + direction) >= 0).astype(np.uint8) << np.uint8(face)
    return bits


def exposed_faces(voxels: Voxels) -> Faces:
    """The outer faces of the occupied cells, by direction, then in cell order."""
    covered = covered_faces(voxels)
    cells, corners = [], []
    for face, square in enumerate(_CORNERS):
        exposed = np.flatnonzero((covered >> face & 1) == 0)
        cells.append(exposed)
        corners.append((voxels.index[exposed, None] + square) * voxels.cell_size)
    cell = np.concatenate(cells)
    return Faces(vertices=np.concatenate(corners), colours=voxels.shown_colours[cell], cell=cell)
