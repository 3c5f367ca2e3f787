"""Binning of a cloud into cells, as in a map."""

import math

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Voxels

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

LARGEST_KEY = 2**62
"""Cells of a box that one number tells apart."""


def distinct(index: Numbers) -> tuple[Numbers, NDArray[np.intp]]:
    """The distinct rows (K, 3) of whole numbers (N, 3), sorted, and the one (N,) of each row."""
    if not len(index):
        return index, np.empty(0, dtype=np.intp)
    low, high = index.min(axis=0), index.max(axis=0)
    shape = [int(b) - int(a) + 1 for a, b in zip(low, high, strict=True)]
    if math.prod(shape) > LARGEST_KEY:
        rows, row = np.unique(index, axis=0, return_inverse=True)
        return rows, row.ravel()
    # One number a row: sorting rows as such is many times slower.
    x, y, z = (index - low).T
    keys, row = np.unique((x * shape[1] + y) * shape[2] + z, return_inverse=True)
    rest, z = np.divmod(keys, shape[2])
    return np.column_stack([*np.divmod(rest, shape[1]), z]) + low, row


def gather(cloud: PointCloud, cell_size: float, min_count: int = 1) -> Voxels:
    """The cells of a cloud that hold at least `min_count` points."""
    index = np.floor(cloud.points / cell_size).astype(np.int64)
    cells, inverse = distinct(index)
    counts = np.bincount(inverse, minlength=len(cells))

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
