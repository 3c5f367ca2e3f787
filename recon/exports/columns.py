"""Clouds and cells as named columns with one value per row, for tables of points."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.colours import colour_names, colours_of
from recon.exports.numbers import leave_out
from recon.notices import notify
from recon.records import Crs, PointCloud, Voxels, cell_centres

Columns = dict[str, NDArray[Any]]

XYZ = ("x", "y", "z")
RGB = ("red", "green", "blue")
NORMAL = ("nx", "ny", "nz")
INDEX = ("index_x", "index_y", "index_z")

MAX_COORDINATE = 1e15
"""Squares of larger ones lose all precision or overflow."""

# Names of single columns, and the fields of Voxels they correspond to.
_KEPT = {"weight": "weights", "num_views": "num_views", "hits": "hits", "passes": "passes"}


def columns_of(data: PointCloud | Voxels) -> Columns:
    """The columns of points, or of cells, whose position is the mean of their points."""
    return _of_cloud(data) if isinstance(data, PointCloud) else _of_voxels(data)


def _of_cloud(cloud: PointCloud) -> Columns:
    columns = _split(XYZ, cloud.points)
    if cloud.colours is not None:
        columns |= _split(RGB, cloud.colours)
    if cloud.sigma is not None:
        columns["sigma"] = cloud.sigma
    return columns | {name: v for name, v in cloud.attributes.items() if name not in columns}


def _of_voxels(voxels: Voxels) -> Columns:
    columns = _split(XYZ, voxels.means)
    if voxels.colours is not None:
        columns |= _split(RGB, voxels.colours)
    # Signed 32 bits: the one integer type that every format here supports.
    columns["count"] = voxels.counts.astype(np.int32)
    columns |= _split(INDEX, voxels.index.astype(np.int32))
    for name, field in _KEPT.items():
        values = getattr(voxels, field)
        if values is not None:
            columns[name] = values if name == "weight" else values.astype(np.int32)
    return columns | {"cell_size": np.full(len(voxels), voxels.cell_size)}


def from_columns(
    columns: Mapping[str, NDArray[Any]], crs: Crs | None = None
) -> PointCloud | Voxels:
    """Cells if the columns include index, count and size, otherwise points.

    Points that are not finite, by which depth cameras mark missing measurements, and columns of
    text are left out with a notice.

    Raises
    ------
    InputError
        If x, y or z is missing, or a value does not fit its name.
    """
    texts = [name for name, values in columns.items() if values.dtype.kind not in "biuf"]
    leave_out(texts, "the table")
    numbers = {name: values for name, values in columns.items() if name not in texts}
    if {*INDEX, *XYZ, "count", "cell_size"} <= numbers.keys() and len(numbers["x"]):
        return _as_voxels(numbers)
    return measured(cloud_in(numbers, crs))


def cloud_in(columns: Mapping[str, NDArray[Any]], crs: Crs | None = None) -> PointCloud:
    """All points of columns; columns other than position and colour become attributes."""
    by_lower = {name.lower(): name for name in reversed(list(columns))}
    missing = [name for name in XYZ if name not in by_lower]
    if missing:
        raise InputError(f"its columns are {', '.join(columns)}, but {missing[0]} is needed")
    places = [by_lower[name] for name in XYZ]
    points = _joined(columns, places).astype(np.float64)
    _check_reach(points)
    colours = colour_names(columns)
    sigma = _sigma(columns)
    used = {*places, *colours, *(["sigma"] if sigma is not None else [])}
    return PointCloud(
        points=points,
        colours=colours_of(columns, colours) if colours else None,
        sigma=sigma,
        attributes={name: values for name, values in columns.items() if name not in used},
        crs=crs,
    )


def _check_reach(points: NDArray[np.float64]) -> None:
    farthest = np.abs(points[np.isfinite(points)]).max(initial=0.0)
    if farthest > MAX_COORDINATE:
        raise InputError(f"a coordinate is {farthest:g}, but at most {MAX_COORDINATE:g} is allowed")


def _sigma(columns: Mapping[str, NDArray[Any]]) -> NDArray[np.float64] | None:
    """The sigma column if it can be a standard deviation, which programs may not mean by it."""
    values = columns.get("sigma")
    if values is None or values.dtype.kind != "f" or (values < 0).any():
        return None
    return values.astype(np.float64)


def measured(cloud: PointCloud) -> PointCloud:
    """The points that are finite; the number of the others is reported."""
    finite = np.flatnonzero(np.isfinite(cloud.points).all(axis=1))
    if len(finite) == len(cloud):
        return cloud
    num_left_out = len(cloud) - len(finite)
    notify("points-left-out", f"{num_left_out} of {len(cloud)} points are not finite; left out")
    return cloud.select(finite)


def _as_voxels(columns: Mapping[str, NDArray[Any]]) -> Voxels:
    cell_size = float(columns["cell_size"][0])
    if (columns["cell_size"] != cell_size).any():
        raise InputError("its cells differ in cell_size, but one is needed")
    index = _joined(columns, INDEX).astype(np.int64)
    kept: dict[str, Any] = {
        field: columns[name].astype(np.float64 if name == "weight" else np.int64)
        for name, field in _KEPT.items()
        if name in columns
    }
    means = _joined(columns, XYZ).astype(np.float64)
    colours = colour_names(columns)
    return Voxels(
        index=index,
        centres=cell_centres(index, cell_size),
        means=means,
        counts=columns["count"].astype(np.int64),
        colours=colours_of(columns, colours) if colours else None,
        cell_size=cell_size,
        **kept,
    )


def _split(names: tuple[str, ...], values: NDArray[Any]) -> Columns:
    return dict(zip(names, values.T, strict=True))


def _joined(columns: Mapping[str, NDArray[Any]], names: tuple[str, ...] | list[str]) -> Any:
    return np.column_stack([columns[name] for name in names])
