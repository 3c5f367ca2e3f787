"""Binning of a cloud into cells, as in a map."""

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Voxels

Array = NDArray[np.float64]


def gather(cloud: PointCloud, cell_size: float, min_count: int = 1) -> Voxels:
    """The cells of a cloud that hold at least `min_count` points."""
    index = np.floor(cloud.points / cell_size).astype(np.int64)
    cells, inverse, counts = np.unique(index, axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.ravel()

    def mean(values: Array) -> Array:
        sums = [np.bincount(inverse, column, len(cells)) for column in values.T]
        means: Array = np.column_stack(sums) / counts[:, None]
        return means

    # Offsets from the cell keep the precision of points far from the origin.
    means = mean(cloud.points - index * cell_size) + cells * cell_size
    colours = cloud.colours
    if colours is not None:
        colours = np.rint(mean(colours.astype(np.float64))).astype(np.uint8)
    kept = counts >= min_count
    return Voxels(
        index=cells[kept],
        centres=(cells[kept].astype(np.float64) + 0.5) * cell_size,
        means=means[kept],
        counts=counts[kept],
        colours=None if colours is None else colours[kept],
        cell_size=cell_size,
    )
