"""The faces of occupied cells that no other occupied cell covers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.records import Voxels

Cells = NDArray[np.int64]

# Corners of the six faces of a unit cell, counter-clockwise seen from outside.
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
    bits = np.zeros(len(voxels), np.uint8)
    for axis in range(3):
        before, after = _neighbours(voxels.index, axis)
        bits[after] |= np.uint8(1 << 2 * axis)
        bits[before] |= np.uint8(2 << 2 * axis)
    return bits


def _neighbours(index: Cells, axis: int) -> tuple[Cells, Cells]:
    """Rows of the cells that touch along an axis: of the lower ones, and of the upper ones."""
    columns = np.roll(index, -axis, axis=1).T
    order = np.lexsort(columns)
    step = np.diff(columns[:, order], axis=1)
    touch = np.flatnonzero((step[0] == 1) & (step[1] == 0) & (step[2] == 0))
    return order[touch], order[touch + 1]


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
