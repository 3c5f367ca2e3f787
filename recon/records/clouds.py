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
    """(M,) world units; None where nothing is known of it."""

    def __post_init__(self) -> None:
        check_shape("points", self.points, (None, 3))
        check_shape("colours", self.colours, (len(self.points), 3))
        if self.colours.dtype != np.uint8:
            raise InputError(f"colours are {self.colours.dtype}, but uint8 is needed")
        if self.sigma is not None:
            check_shape("sigma", self.sigma, (len(self.points),))

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, T_target_source: ArrayLike) -> "PointCloud":
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

    def __len__(self) -> int:
        return len(self.index)

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "Voxels":
        """The cells of `rows`, in that order."""
        names = ("index", "centres", "means", "counts", "colours")
        return Voxels(
            **{name: getattr(self, name)[rows] for name in names}, cell_size=self.cell_size
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Segments:
    """A part number for each cell."""

    label: NDArray[np.int32]
    """(K,) 0, 1, ...; -1 = none."""

    @property
    def num_segments(self) -> int:
        """How many parts there are."""
        return int(self.label.max(initial=-1)) + 1
