"""Number of pairs that saw each object."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Recognition, Voxels

_REACH = 1 << 20
"""Number of addressable cells on either side of the origin."""
MIN_POINTS_OF_VIEW = 10
"""Number of points that a pair needs on an object to have seen it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CellCounts:
    """Numbers of points per cell and pair."""

    keys: NDArray[np.int64]
    """(C,) key of the cell."""
    pairs: NDArray[np.int64]
    """(C,) number of the pair."""
    counts: NDArray[np.int64]
    """(C,) number of points."""


def count_cells(
    cloud: PointCloud, pairs: NDArray[np.integer] | int, cell_size: float
) -> CellCounts:
    """Count the points of a cloud (world) by cell and pair, ignoring those out of reach."""
    is_near = (np.abs(cloud.points) < _REACH * cell_size).all(axis=1)
    keys = _keys(np.floor(cloud.points[is_near] / cell_size).astype(np.int64))
    numbers = np.broadcast_to(np.asarray(pairs, dtype=np.int64), len(cloud))[is_near]
    rows, counts = np.unique(np.column_stack([keys, numbers]), axis=0, return_counts=True)
    return CellCounts(keys=rows[:, 0], pairs=rows[:, 1], counts=counts)


def with_views(recognition: Recognition, voxels: Voxels, seen: Iterable[CellCounts]) -> Recognition:
    """The same objects, with the number of pairs that saw each."""
    points: dict[tuple[int, int], int] = {}
    for object_id, number, count in _hits(recognition, voxels, seen):
        points[object_id, number] = points.get((object_id, number), 0) + count
    views = [object_id for (object_id, _), n in points.items() if n >= MIN_POINTS_OF_VIEW]
    counted = tuple(replace(found, views=views.count(found.id)) for found in recognition.objects)
    return replace(recognition, objects=counted)


def _hits(
    recognition: Recognition, voxels: Voxels, seen: Iterable[CellCounts]
) -> Iterator[tuple[int, int, int]]:
    """Object, pair and number of points, for every cell of an object that a pair hit."""
    keys = _keys(voxels.index)
    order = np.argsort(keys)
    for cells in seen:
        found = _lookup(keys[order], recognition.label[order], cells.keys)
        is_hit = found >= 0
        columns = (found[is_hit], cells.pairs[is_hit], cells.counts[is_hit])
        yield from zip(*(column.tolist() for column in columns), strict=True)


def _keys(index: NDArray[np.int64]) -> NDArray[np.int64]:
    shifted = index + _REACH
    keys: NDArray[np.int64] = (shifted[:, 0] << 42) | (shifted[:, 1] << 21) | shifted[:, 2]
    return keys


def _lookup(
    sorted_keys: NDArray[np.int64], values: NDArray[np.int32], keys: NDArray[np.int64]
) -> NDArray[np.int32]:
    if not len(sorted_keys):
        return np.full(len(keys), -1, dtype=np.int32)
    at = np.minimum(np.searchsorted(sorted_keys, keys), len(sorted_keys) - 1)
    return np.where(sorted_keys[at] == keys, values[at], -1).astype(np.int32)
