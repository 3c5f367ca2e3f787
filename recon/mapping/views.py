"""Number of pairs that saw each object."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Recognition, Voxels

Integers = NDArray[np.int64]

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
    return CellCounts(**_summed(keys, numbers, np.ones(len(keys), np.int64)))


def with_views(recognition: Recognition, voxels: Voxels, seen: Iterable[CellCounts]) -> Recognition:
    """The same objects, with the number of pairs that saw each."""
    keys = _keys(voxels.index)
    order = np.argsort(keys)
    keys, labels = keys[order], recognition.label[order]
    nothing = np.zeros((3, 0), np.int64)
    hits = [nothing, *(_hits(keys, labels, cells) for cells in seen)]
    points = _summed(*np.concatenate(hits, axis=1))
    views = points["keys"][points["counts"] >= MIN_POINTS_OF_VIEW]
    counted = tuple(
        replace(found, views=int((views == found.id).sum())) for found in recognition.objects
    )
    return replace(recognition, objects=counted)


def _hits(keys: Integers, labels: NDArray[np.int32], cells: CellCounts) -> Integers:
    """(3, N) object, pair and number of points, for the objects that pairs hit."""
    found = _lookup(keys, labels, cells.keys).astype(np.int64)
    is_hit = found >= 0
    summed = _summed(found[is_hit], cells.pairs[is_hit], cells.counts[is_hit])
    return np.array([*summed.values()])


def _summed(keys: Integers, pairs: Integers, counts: Integers) -> dict[str, Integers]:
    """The distinct keys and pairs, in order, and the sums of their counts."""
    order = np.lexsort((pairs, keys))
    keys, pairs = keys[order], pairs[order]
    is_first = np.ones(len(keys), np.bool_)
    is_first[1:] = (keys[1:] != keys[:-1]) | (pairs[1:] != pairs[:-1])
    starts = np.flatnonzero(is_first)
    sums = np.add.reduceat(counts[order], starts) if len(starts) else counts
    return {"keys": keys[starts], "pairs": pairs[starts], "counts": sums}


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
