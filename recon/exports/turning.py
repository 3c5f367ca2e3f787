"""Conversion between y up (the world) and z up (robotics, surveying): a quarter turn about x."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from recon.records import Mesh, PointCloud, Voxels
from recon.records.clouds import NORMALS

R_ZUP_YUP: NDArray[np.int64] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Rotates the world's points into the frame of a format with z up: (x, -z, y)."""

R_YUP_ZUP: NDArray[np.int64] = R_ZUP_YUP.T
"""The inverse rotation."""

Turnable = TypeVar("Turnable", bound=PointCloud | Voxels | Mesh)


def turned(data: Turnable, rotation: NDArray[np.int64]) -> Turnable:
    """Points, triangles, or cells (in their new index order), rotated by quarter turns."""
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
    """Points (N, 3) rotated by quarter turns, exactly: columns change positions and signs."""
    source = np.abs(rotation).argmax(axis=1)
    moved = points[:, source]
    is_turned = rotation[np.arange(3), source] < 0
    moved[:, is_turned] *= -1
    # Avoid negative zeros.
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
    """Cells (K, 3) rotated about the origin by their centres, in half cells."""
    turned_halves: NDArray[np.int64] = (2 * index + 1) @ rotation.T
    return (turned_halves - 1) // 2
