"""Cells of several partitions as one record, and coarser cells."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.records import Voxels, cell_centres
from recon.voxelmap import VoxelMap

SUMMED = ("counts", "weights")
LARGEST = ("num_views", "hits", "passes")
"""Fields for which a coarser cell has the maximum of its cells."""


def joined(parts: Iterable[Voxels], cell_size: float) -> Voxels:
    """The cells of all parts, which must be disjoint, in index order."""
    found = [part for part in parts if len(part)]
    if not found:
        return VoxelMap(cell_size).occupied()
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in found])
        for name in Voxels.__slots__
        if isinstance(getattr(found[0], name), np.ndarray)
    }
    order = np.lexsort(columns["index"].T[::-1])
    return Voxels(**{name: c[order] for name, c in columns.items()}, cell_size=cell_size)


def coarser(voxels: Voxels, factor: int) -> Voxels:
    """The same points in cells `factor` times as large."""
    if factor == 1 or not len(voxels):
        return voxels
    index, row = np.unique(voxels.index // factor, axis=0, return_inverse=True)
    size, counts = factor * voxels.cell_size, np.bincount(row, voxels.counts)
    colours = voxels.colours

    def mean(values: NDArray[Any]) -> NDArray[np.float64]:
        """Mean (K, 3), weighted by the number of points."""
        sums = [np.bincount(row, axis * voxels.counts) for axis in values.T.astype(np.float64)]
        return np.column_stack(sums) / counts[:, None]

    kept: dict[str, Any] = {}
    for name in (*SUMMED, *LARGEST):
        values = getattr(voxels, name)
        if values is not None:
            kept[name] = np.zeros(len(index), values.dtype)
            gather = np.add if name in SUMMED else np.maximum
            gather.at(kept[name], row, values)
    return Voxels(
        index=index,
        centres=cell_centres(index, size),
        means=mean(voxels.means),
        colours=None if colours is None else np.rint(mean(colours)).astype(np.uint8),
        cell_size=size,
        **kept,
    )
