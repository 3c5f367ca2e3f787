"""Points, with colours if known, and the occupied cells that hold them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError, as_numbers, check_shape, check_type
from recon.geometry import transform

GREY = 128
"""Grey level shown for points without a known colour."""

NORMALS = (
    ("nx", "ny", "nz"), ("Nx", "Ny", "Nz"), ("NX", "NY", "NZ"),
    ("normal_x", "normal_y", "normal_z"), ("NormalX", "NormalY", "NormalZ"),
)  # fmt: skip
"""Attribute names of normals in common programs; they are rotated with the points."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Crs:
    """A coordinate reference system, as stored in a LAS file."""

    records: tuple[tuple[int, bytes], ...]
    """Number and content of each record: 2112 is WKT, 34735 to 34737 are the GeoTIFF keys."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointCloud:
    """Points with their measurements: colour, standard deviation of the depth, attributes.

    The owner defines the frame: the left camera for a pair, the world for a run.
    """

    points: NDArray[np.float64]
    """(M, 3) world units."""
    colours: NDArray[np.uint8] | None = None
    """(M, 3) RGB; None if unknown."""
    sigma: NDArray[np.float64] | None = None
    """(M,) world units; NaN or None if unknown."""
    attributes: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """(M,) values of each, by name; normals are in the frame of the points."""
    crs: Crs | None = None
    """Reference system of the points as surveyed, with z up."""

    def __post_init__(self) -> None:
        check_shape("points", self.points, (None, 3))
        object.__setattr__(self, "points", _as_floats("points", self.points))
        if self.colours is not None:
            check_shape("colours", self.colours, (len(self.points), 3))
            if self.colours.dtype != np.uint8:
                raise InputError(f"colours are {self.colours.dtype}, but uint8 is needed")
        if self.sigma is not None:
            check_shape("sigma", self.sigma, (len(self.points),))
            object.__setattr__(self, "sigma", _as_floats("sigma", self.sigma))
            if (self.sigma < 0).any():
                raise InputError(f"sigma is {self.sigma.min()}, but 0 or more is needed")
        check_type("attributes", self.attributes, Mapping)
        for name, values in self.attributes.items():
            check_shape(name, values, (len(self.points),))
        object.__setattr__(
            self, "attributes", {name: _native(v) for name, v in self.attributes.items()}
        )

    def __len__(self) -> int:
        return len(self.points)

    @property
    def shown_colours(self) -> NDArray[np.uint8]:
        """(M, 3) RGB; mid grey if the colours are unknown."""
        return _shown(self.colours, len(self))

    def __repr__(self) -> str:
        return f"PointCloud({len(self)} points{'' if self.sigma is None else ' with sigma'})"

    def transformed(self, T_target_source: ArrayLike) -> "PointCloud":
        """The same points and normals in the target frame; distances and sigmas stay."""
        attributes = dict(self.attributes)
        T = as_numbers("T_target_source", T_target_source)
        check_shape("T_target_source", T, (4, 4))
        for names in NORMALS:
            if set(names) <= attributes.keys():
                normals = np.column_stack([attributes[name] for name in names]) @ T[:3, :3].T
                attributes |= zip(names, normals.T, strict=True)
        return PointCloud(
            points=transform(T, self.points),
            colours=self.colours,
            sigma=self.sigma,
            attributes=attributes,
        )

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_] | slice) -> "PointCloud":
        """The points of `rows`, in that order."""
        return PointCloud(
            points=self.points[rows],
            colours=None if self.colours is None else self.colours[rows],
            sigma=None if self.sigma is None else self.sigma[rows],
            attributes={name: values[rows] for name, values in self.attributes.items()},
            crs=self.crs,
        )


def _as_floats(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Real numbers as native floats of 32 or 64 bits: whole ones and halves would overflow."""
    if values.dtype.kind not in "fiu":
        raise InputError(f"{name} are {values.dtype}, but real numbers are needed")
    is_float = values.dtype.kind == "f" and values.dtype.itemsize in (4, 8)
    return _native(values) if is_float else values.astype(np.float64)


def _native(values: NDArray[Any]) -> NDArray[Any]:
    """The same values in the byte order of this machine."""
    return values if values.dtype.isnative else values.astype(values.dtype.newbyteorder("="))


def _shown(colours: NDArray[np.uint8] | None, num_rows: int) -> NDArray[np.uint8]:
    return np.full((num_rows, 3), GREY, np.uint8) if colours is None else colours


def cell_centres(index: NDArray[np.integer], cell_size: float) -> NDArray[np.float64]:
    """(K, 3) middles of cells, world, by their index (K, 3)."""
    centres: NDArray[np.float64] = (index.astype(np.float64) + 0.5) * cell_size
    return centres


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Voxels:
    """The occupied cells of a map, in the order of their index (x, then y, then z)."""

    index: NDArray[np.int64]
    """(K, 3) cell index along x, y, z: floor(point / cell_size)."""
    centres: NDArray[np.float64]
    """(K, 3) middle of the cell, world."""
    means: NDArray[np.float64]
    """(K, 3) mean position of the cell's points, world."""
    counts: NDArray[np.int64]
    """(K,) number of points."""
    cell_size: float
    """World units."""
    colours: NDArray[np.uint8] | None = None
    """(K, 3) mean RGB; None where the points have no colours."""
    weights: NDArray[np.float64] | None = None
    """(K,) sum of the points' weights by sigma; this and the fields below are None if not kept."""
    num_views: NDArray[np.int64] | None = None
    """(K,) number of distinct views with a point in the cell."""
    hits: NDArray[np.int64] | None = None
    """(K,) scans with a point in the cell."""
    passes: NDArray[np.int64] | None = None
    """(K,) scans with a ray that passes through the cell to a point behind it."""

    def __post_init__(self) -> None:
        if not 0 < self.cell_size < np.inf:
            raise InputError(f"cell_size is {self.cell_size}, but a finite number > 0 is needed")
        num_cells = len(self.index)
        for name in Voxels.__slots__:
            values = getattr(self, name)
            if isinstance(values, np.ndarray):
                is_row = name in ("index", "centres", "means", "colours")
                check_shape(name, values, (num_cells, 3) if is_row else (num_cells,))
        if num_cells and self.counts.min() < 1:
            raise InputError(f"counts contain {self.counts.min()}, but 1 or more is needed")

    @classmethod
    def occupied(
        cls, index: NDArray[np.int64], cell_size: float, colours: NDArray[np.uint8] | None = None
    ) -> "Voxels":
        """Cells of which only that they are occupied is known: one point each, at its middle."""
        centres = cell_centres(index, cell_size)
        counts = np.ones(len(index), np.int64)
        return cls(
            index=index, centres=centres, means=centres, counts=counts, colours=colours,
            cell_size=cell_size,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.index)

    @property
    def shown_colours(self) -> NDArray[np.uint8]:
        """(K, 3) RGB; mid grey if the colours are unknown."""
        return _shown(self.colours, len(self))

    def __repr__(self) -> str:
        return f"Voxels({len(self)} cells of {self.cell_size:g}, {self.counts.sum()} points)"

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
    """(NX, NZ) one value per cell, along x and z."""
    origin_xz: NDArray[np.float64]
    """(2,) world x and z of the outer corner of cell [0, 0]."""
    cell_size: float
    """World units."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Segments:
    """A part number for each cell."""

    label: NDArray[np.int32]
    """(K,) 0, 1, ...; -1 = none."""
