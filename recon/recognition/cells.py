"""Binning of a cloud into cells, as in a map."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud, Voxels, cell_centres

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

LARGEST_KEY = 2**62
"""Cells of a box that one number tells apart."""
ROOM = 8
"""Most places for each number from which a list of all places is faster than sorting."""
TOO_MANY, WIDER = 2.0, 1.25
"""Coarse cells over those wanted above which they are widened, and by how much."""
BLOCK = 1_000_000
"""Points that are gathered at a time: their temporaries are many times as large as they."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gathered:
    """The cells of a cloud, and where its points went."""

    voxels: Voxels
    cell: Numbers
    """(N,) row of each point's cell."""

    def of_points(self, label: NDArray[np.int32]) -> NDArray[np.int32]:
        """Labels (N,) of points by those (K,) of their cells."""
        labels: NDArray[np.int32] = label[self.cell]
        return labels


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
    keys, row = _distinct_keys((x * shape[1] + y) * shape[2] + z, math.prod(shape))
    rest, z = np.divmod(keys, shape[2])
    return np.column_stack([*np.divmod(rest, shape[1]), z]) + low, row


def _distinct_keys(keys: Numbers, size: int) -> tuple[Numbers, NDArray[np.intp]]:
    """The distinct numbers (K,) from 0 to `size`, sorted, and the one (N,) of each."""
    if size > ROOM * len(keys):
        return np.unique(keys, return_inverse=True)
    is_there = np.zeros(size, dtype=np.bool_)
    is_there[keys] = True
    return np.flatnonzero(is_there), (np.cumsum(is_there) - 1)[keys]


def gather(cloud: PointCloud, cell_size: float, min_count: int = 1) -> Voxels:
    """The cells of a cloud that hold at least `min_count` points."""
    voxels = gather_points(cloud, cell_size).voxels
    return voxels.select(voxels.counts >= min_count)


def gather_points(cloud: PointCloud, cell_size: float) -> Gathered:
    """All cells of a cloud, and the cell of each point."""
    blocks = [slice(first, first + BLOCK) for first in range(0, max(len(cloud), 1), BLOCK)]
    own = [distinct(_cells_of(cloud.points[block], cell_size)) for block in blocks]
    cells, row = distinct(np.concatenate([rows for rows, _ in own]))
    borders = np.cumsum([0, *(len(rows) for rows, _ in own)])
    cell = np.concatenate(
        [row[low : low + len(rows)][at] for low, (rows, at) in zip(borders, own, strict=False)]
    )
    counts = np.bincount(cell, minlength=len(cells))
    sums = np.zeros((2, len(cells), 3))
    for block in blocks:
        # Offsets from the cell keep the precision of points far from the origin.
        offsets = cloud.points[block] - cells[cell[block]] * cell_size
        sums[0] += _sums(offsets, cell[block], len(cells))
        if cloud.colours is not None:
            sums[1] += _sums(cloud.colours[block], cell[block], len(cells))
    offsets, colours = sums / counts[:, None]
    voxels = Voxels(
        index=cells,
        centres=cell_centres(cells, cell_size),
        means=offsets + cells * cell_size,
        counts=counts,
        colours=None if cloud.colours is None else np.rint(colours).astype(np.uint8),
        cell_size=cell_size,
    )
    return Gathered(voxels=voxels, cell=cell)


def _cells_of(points: Array, cell_size: float) -> Numbers:
    return np.floor(points / cell_size).astype(np.int64)


def _sums(values: NDArray[np.generic], cell: NDArray[np.integer], count: int) -> Array:
    """Sums (count, 3) of rows (N, 3) by their cells."""
    return np.column_stack([np.bincount(cell, column, count) for column in values.T])


def coarser(cells: Voxels, count: int) -> tuple[Voxels, NDArray[np.intp], NDArray[np.intp]]:
    """Larger cells of a surface.

    Parameters
    ----------
    count : int
        Approximate number of cells wanted.

    Returns
    -------
    coarse : Voxels
        C cells with the means of the cells in each; the rest is that of one of them.
    first : (C,) the cell in each that it is
    cell : (K,) the coarse cell around each
    """
    side = cells.cell_size * math.sqrt(len(cells) / count)
    rows, cell = distinct(_cells_of(cells.means, side))
    while len(rows) > TOO_MANY * count:
        # No surface: specks apart from each other, or threads.
        side *= WIDER
        rows, cell = distinct(_cells_of(cells.means, side))
    first = np.empty(len(rows), dtype=np.intp)
    first[cell[::-1]] = np.arange(len(cell))[::-1]
    coarse = replace(cells.select(first), means=means(cells.means, cell), cell_size=side)
    return coarse, first, cell


def means(rows: Array, label: NDArray[np.integer]) -> Array:
    """Mean rows (L, D) of rows (N, D) with the same label."""
    counts = np.bincount(label)
    averages: Array = _sums(rows, label, len(counts)) / counts[:, None]
    return averages


def trust_by_points(cells: Voxels, limits: tuple[float, float]) -> Array:
    """Trust (N,) in each cell, within limits: those with few points are often off the surface."""
    trust: Array = np.clip(cells.counts / np.median(cells.counts), *limits)
    return trust
