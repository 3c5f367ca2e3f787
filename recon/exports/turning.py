"""The world has y up; formats of robots and surveyors have z up: a quarter turn about x."""

from dataclasses import replace
from typing import overload

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Voxels
from recon.voxelmap.table import order_of

R_ZUP_YUP: NDArray[np.int64] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Brings the world's points into the frame of a format that has z up: (x, -z, y)."""

R_YUP_ZUP: NDArray[np.int64] = R_ZUP_YUP.T
"""And back."""


@overload
def turned(data: PointCloud, rotation: NDArray[np.int64]) -> PointCloud: ...


@overload
def turned(data: Voxels, rotation: NDArray[np.int64]) -> Voxels: ...


def turned(data: PointCloud | Voxels, rotation: NDArray[np.int64]) -> PointCloud | Voxels:
    """Points, or cells in the order of their new index, turned by quarters."""
    if isinstance(data, PointCloud):
        return replace(data, points=data.points @ rotation.T)
    index = turned_index(data.index, rotation)
    cells = replace(
        data, index=index, centres=data.centres @ rotation.T, means=data.means @ rotation.T
    )
    return cells.select(order_of(index))


def turned_index(index: NDArray[np.int64], rotation: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cells (K, 3) turned: what turns round are their middles, in halves of a cell."""
    turned_halves: NDArray[np.int64] = (2 * index + 1) @ rotation.T
    return (turned_halves - 1) // 2
