"""Sets of the views that saw a cell."""

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap.channels import Columns, Inside, Scan


class ViewSets:
    """Views with a point in a row: unique pairs of row and view."""

    def __init__(self) -> None:
        self._pairs = np.zeros(0, np.int64)
        self._new: list[NDArray[np.int64]] = []
        self._num_new = 0

    def check(self, scan: Scan) -> None:
        """Raise `InputError` if the view has no number."""
        if scan.view is None or not 0 <= scan.view < 2**31:
            raise InputError(f"view is {scan.view}, but a map that keeps views needs its number")

    def add(self, scan: Scan, rows: NDArray[np.int64]) -> None:
        """Add the view to the set of every row."""
        assert scan.view is not None
        self._unite(_distinct(rows) << 32 | scan.view)

    def merge(self, other: "ViewSets", rows: NDArray[np.int64]) -> None:
        """Unite the sets of two maps."""
        theirs = other.pairs
        self._unite(rows[theirs >> 32] << 32 | theirs & 0xFFFFFFFF)

    def cropped(self, rows: NDArray[np.int64], is_inside: Inside) -> "ViewSets":
        """The sets of some rows, given in ascending order."""
        place = np.searchsorted(rows, self.pairs >> 32)
        is_kept = np.isin(self.pairs >> 32, rows)
        part = ViewSets()
        part._unite((place << 32 | self.pairs & 0xFFFFFFFF)[is_kept])
        return part

    @property
    def pairs(self) -> NDArray[np.int64]:
        """(P,) row << 32 | view, sorted, unique."""
        self._pairs = _distinct(np.concatenate([self._pairs, *self._new]))
        self._new, self._num_new = [], 0
        return self._pairs

    def columns(self, order: NDArray[np.int64]) -> Columns:
        """Pairs of cell, by its position in the order, and view."""
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        pairs = np.sort(place[self.pairs >> 32] << 32 | self.pairs & 0xFFFFFFFF)
        return {"view_cell": pairs >> 32, "view": pairs & 0xFFFFFFFF}

    def restore(self, columns: Columns, num_rows: int) -> None:
        """Load the pairs of a file."""
        cell, view = columns["view_cell"].astype(np.int64), columns["view"].astype(np.int64)
        if not ((cell >= 0) & (cell < num_rows)).all():
            raise InputError(f"view_cell refers to a cell beyond the {num_rows} of the map")
        self._pairs = cell << 32 | view

    def fields(self, order: NDArray[np.int64], index: NDArray[np.int64]) -> Columns:
        """`Voxels.num_views`."""
        counts = np.bincount(self.pairs >> 32, minlength=int(order.max(initial=-1)) + 1)
        return {"num_views": counts[order]}

    def _unite(self, pairs: NDArray[np.int64]) -> None:
        self._new.append(pairs)
        self._num_new += len(pairs)
        # A view may arrive in many chunks: memory stays bounded by the size of the sets.
        if self._num_new > len(self._pairs) + (1 << 16):
            _ = self.pairs


def _distinct(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """The distinct values, sorted, in a quarter of the time of `numpy.unique`, which hashes."""
    ordered = np.sort(values)
    is_first = np.ones(len(ordered), np.bool_)
    is_first[1:] = ordered[1:] != ordered[:-1]
    return ordered[is_first]
