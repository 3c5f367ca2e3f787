"""Channels: optional data of the cells of a map, in addition to hits, position and colour."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import as_numbers, check_finite, check_number, check_shape
from recon.records import PointCloud

Columns = Mapping[str, NDArray[Any]]
Inside = Callable[[NDArray[np.integer]], NDArray[np.bool_]]
"""Mask (K,) of the cells (K, 3) that lie inside a box."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """Points of one call of `VoxelMap.insert`."""

    cloud: PointCloud
    """World."""
    origin: NDArray[np.float64] | None
    """(3,) camera position, world."""
    view: int | None
    """Number of the view."""

    def __post_init__(self) -> None:
        if self.view is not None:
            check_number("view", self.view, low=0)


def eye_of(origin: ArrayLike | None) -> NDArray[np.float64] | None:
    """The validated camera position (3,)."""
    if origin is None:
        return None
    eye = as_numbers("origin", origin)
    check_shape("origin", eye, (3,))
    check_finite("origin", eye)
    return eye


class Channel(Protocol):
    """Additive data of the cells of a map."""

    def check(self, scan: Scan) -> None:
        """Raise `InputError` if the scan lacks the data of the channel."""

    def add(self, scan: Scan, rows: NDArray[np.int64]) -> None:
        """Add a scan, with the row (N,) of each of its points."""

    def merge(self, other: Any, rows: NDArray[np.int64]) -> None:
        """Add another map's channel, whose row k is row `rows[k]` here."""

    def cropped(self, rows: NDArray[np.int64], is_inside: Inside) -> Self:
        """The channel of a map with some of the rows, and the cells inside."""

    def columns(self, order: NDArray[np.int64]) -> Columns:
        """The arrays of a file, for the rows of the map in this order."""

    def restore(self, columns: Columns, num_rows: int) -> None:
        """Load the arrays of a file, for the rows of the map in file order."""

    def fields(self, order: NDArray[np.int64], index: NDArray[np.int64]) -> Columns:
        """The fields of `Voxels` from this channel, for rows of the map and their cells."""


class RowSums:
    """Integer sums for each row of the map."""

    name: str
    """Name of the column in a file."""
    width: int
    """Numbers per row."""

    def __init__(self) -> None:
        self.sums = np.zeros((0, self.width), np.uint64)

    def check(self, scan: Scan) -> None:
        """Raise `InputError` if the scan lacks the data of the channel."""

    def amounts(self, scan: Scan) -> NDArray[np.uint64]:
        """Amounts (N, width) that each point adds."""
        raise NotImplementedError

    def add(self, scan: Scan, rows: NDArray[np.int64]) -> None:
        """Add the amounts of each point to the row of its cell."""
        self._add(rows, self.amounts(scan))

    def merge(self, other: "RowSums", rows: NDArray[np.int64]) -> None:
        """Add the sums of another map."""
        num = min(len(rows), len(other.sums))
        # A copy, since a map may be merged with itself.
        self._add(rows[:num], other.sums[:num].copy())

    def cropped(self, rows: NDArray[np.int64], is_inside: Inside) -> Self:
        """The sums of some rows."""
        part = copy.copy(self)
        part.sums = self.of(rows)
        return part

    def columns(self, order: NDArray[np.int64]) -> Columns:
        """The sums, in the order of the file."""
        return {self.name: self.of(order)}

    def restore(self, columns: Columns, num_rows: int) -> None:
        """Load the sums of a file."""
        self.sums = columns[self.name].astype(np.uint64)
        check_shape(self.name, self.sums, (num_rows, self.width))

    def of(self, rows: NDArray[np.int64]) -> NDArray[np.uint64]:
        """The sums of some rows."""
        self._reserve(int(rows.max(initial=-1)) + 1)
        return self.sums[rows]

    def _add(self, rows: NDArray[np.int64], amounts: NDArray[np.uint64]) -> None:
        self._reserve(int(rows.max(initial=-1)) + 1)
        np.add.at(self.sums, rows, amounts)

    def _reserve(self, num_rows: int) -> None:
        if num_rows > len(self.sums):
            # A quarter more than needed, so that growing by single cells stays cheap.
            more = np.zeros((num_rows + num_rows // 4 - len(self.sums), self.width), np.uint64)
            self.sums = np.concatenate([self.sums, more])
