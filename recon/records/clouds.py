"""Coloured points, and the occupied cells they gather in."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, check_shape
from recon.geometry import transform


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointCloud:
    """Coloured points, each with the standard deviation of its depth.

    The frame is the one its holder names: left camera out of a pair, world in a run.
    """

    points: NDArray[np.float64]
    """(M, 3) world units."""
    colours: NDArray[np.uint8]
    """(M, 3) RGB."""
    sigma: NDArray[np.float64] | None = None
    """(M,) world units; NaN or None where nothing is known of it."""

    def __post_init__(self) -> None:
        check_shape("points", self.points, (None, 3))
        if self.points.dtype.kind not in "fiu":
            raise InputError(f"points are {self.points.dtype}, but real numbers are needed")
        check_shape("colours", self.colours, (len(self.points), 3))
        if self.colours.dtype != np.uint8:
            raise InputError(f"colours are {self.colours.dtype}, but uint8 is needed")
        if self.sigma is not None:
            check_shape("sigma", self.sigma, (len(self.points),))
            if (self.sigma < 0).any():
                raise InputError(f"sigma is {self.sigma.min()}, but 0 or more is needed")

    def __len__(self) -> int:
        return len(self.points)

    def transformed(self, T_target_source: ArrayLike) -> "PointCloud":
        """The same points in the target frame; distances and sigmas stay."""
        return PointCloud(
            points=transform(T_target_source, self.points), colours=self.colours, sigma=self.sigma
        )

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "PointCloud":
        """The points of `rows`, in that order."""
        sigma = None if self.sigma is None else self.sigma[rows]
        return PointCloud(points=self.points[rows], colours=self.colours[rows], sigma=sigma)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Voxels:
    """The occupied cells of a map, in the order of their index (x, then y, then z)."""

    index: NDArray[np.int64]
    """(K, 3) cell number along x, y, z: floor(point / cell_size)."""
    centres: NDArray[np.float64]
    """(K, 3) middle of the cell, world."""
    means: NDArray[np.float64]
    """(K, 3) mean position of the cell's points, world."""
    counts: NDArray[np.int64]
    """(K,) number of points."""
    colours: NDArray[np.uint8]
    """(K, 3) mean RGB."""
    cell_size: float
    """World units."""
    weights: NDArray[np.float64] | None = None
    """(K,) sum of the points' weights by sigma; this and what follows None where not kept."""
    num_views: NDArray[np.int64] | None = None
    """(K,) number of distinct views with a point in the cell."""
    hues: NDArray[np.int64] | None = None
    """(K, 13) points by hue: 12 bins of 30 degrees from red on, then the grey ones."""
    hits: NDArray[np.int64] | None = None
    """(K,) scans with a point in the cell."""
    passes: NDArray[np.int64] | None = None
    """(K,) scans that looked through the cell to a point behind."""

    def __len__(self) -> int:
        return len(self.index)

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "Voxels":
        """The cells of `rows`, in that order."""
        columns = {
            name: column[rows]
            for name in Voxels.__slots__
            if isinstance(column := getattr(self, name), np.ndarray)
        }
        return Voxels(**columns, cell_size=self.cell_size)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundGrid:
    """The floor as square cells, seen from above."""

    cells: NDArray[np.generic]
    """(NX, NZ) one value a cell, along x, then z."""
    origin_xz: NDArray[np.float64]
    """(2,) world x and z of the outer corner of cell [0, 0]."""
    cell_size: float
    """World units."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Segments:
    """A part number for each cell."""

    label: NDArray[np.int32]
    """(K,) 0, 1, ...; -1 = none."""

    @property
    def num_segments(self) -> int:
        """How many parts there are."""
        return int(self.label.max(initial=-1)) + 1
