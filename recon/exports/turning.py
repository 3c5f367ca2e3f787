"""The world has y up; formats of robots and surveyors have z up: a quarter turn about x."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from recon.records import Mesh, PointCloud, Voxels
from recon.records.clouds import NORMALS

R_ZUP_YUP: NDArray[np.int64] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Brings the world's points into the frame of a format that has z up: (x, -z, y)."""

R_YUP_ZUP: NDArray[np.int64] = R_ZUP_YUP.T
"""And back."""

Turnable = TypeVar("Turnable", bound=PointCloud | Voxels | Mesh)


def turned(data: Turnable, rotation: NDArray[np.int64]) -> Turnable:
    """Points, triangles, or cells in the order of their new index, turned by quarters."""
    found: Any
    if isinstance(data, PointCloud):
        found = replace(
            data,
            points=turned_points(data.points, rotation),
            attributes=_turned_normals(data.attributes, rotation),
        )
    elif isinstance(data, Mesh):
        normals = None if data.normals is None else turned_points(data.normals, rotation)
        found = replace(data, vertices=turned_points(data.vertices, rotation), normals=normals)
    else:
        found = _turned_cells(data, rotation)
    return cast(Turnable, found)


def _turned_cells(data: Voxels, rotation: NDArray[np.int64]) -> Voxels:
    from recon.voxelmap.table import order_of

    index = turned_index(data.index, rotation)
    cells = replace(
        data,
        index=index,
        centres=turned_points(data.centres, rotation),
        means=turned_points(data.means, rotation),
    )
    return cells.select(order_of(index))


def turned_points(points: NDArray[Any], rotation: NDArray[np.int64]) -> NDArray[Any]:
    """Points (N, 3) turned by quarters, to the last bit: columns change places and signs."""
    source = np.abs(rotation).argmax(axis=1)
    moved = points[:, source]
    is_turned = rotation[np.arange(3), source] < 0
    moved[:, is_turned] *= -1
    # No minus before a zero.
    return np.asarray(moved + 0)


def _turned_normals(
    attributes: Mapping[str, NDArray[Any]], rotation: NDArray[np.int64]
) -> Mapping[str, NDArray[Any]]:
    changed = dict(attributes)
    for names in NORMALS:
        if set(names) <= changed.keys():
            normals = np.column_stack([changed[name] for name in names])
            changed |= zip(names, turned_points(normals, rotation).T, strict=True)
    return changed


def turned_index(index: NDArray[np.int64], rotation: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cells (K, 3) turned: what turns round are their middles, in halves of a cell."""
    turned_halves: NDArray[np.int64] = (2 * index + 1) @ rotation.T
    return (turned_halves - 1) // 2
