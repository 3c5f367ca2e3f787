"""Clouds and cells as named columns, one value a row: what tables of points can hold."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.records import PointCloud, Voxels

Columns = dict[str, NDArray[Any]]

XYZ = ("x", "y", "z")
RGB = ("red", "green", "blue")
INDEX = ("index_x", "index_y", "index_z")

# Names of single columns and of the fields of Voxels that they hold.
_KEPT = {"weight": "weights", "num_views": "num_views", "hits": "hits", "passes": "passes"}
_HUES = tuple(f"hue_{number:02d}" for number in range(13))


def columns_of(data: PointCloud | Voxels) -> Columns:
    """The columns of points, or of cells, whose place is the mean of their points."""
    return _of_cloud(data) if isinstance(data, PointCloud) else _of_voxels(data)


def _of_cloud(cloud: PointCloud) -> Columns:
    columns = _split(XYZ, cloud.points) | _split(RGB, cloud.colours)
    return columns if cloud.sigma is None else columns | {"sigma": cloud.sigma}


def _of_voxels(voxels: Voxels) -> Columns:
    columns = _split(XYZ, voxels.means) | _split(RGB, voxels.colours)
    # Signed 32 bits: the one whole number that every format here has.
    columns["count"] = voxels.counts.astype(np.int32)
    columns |= _split(INDEX, voxels.index.astype(np.int32))
    for name, field in _KEPT.items():
        values = getattr(voxels, field)
        if values is not None:
            columns[name] = values if name == "weight" else values.astype(np.int32)
    if voxels.hues is not None:
        columns |= _split(_HUES, voxels.hues.astype(np.int32))
    return columns | {"cell_size": np.full(len(voxels), voxels.cell_size)}


def from_columns(columns: Mapping[str, NDArray[Any]]) -> PointCloud | Voxels:
    """Cells where the columns name their index, count and size, otherwise points.

    Points without colour are grey; those that are not finite, with which depth cameras mark that
    nothing was measured, are left out.

    Raises
    ------
    InputError
        Where x, y or z is missing.
    """
    missing = [name for name in XYZ if name not in columns]
    if missing:
        raise InputError(f"its columns are {', '.join(columns)}, but {missing[0]} is needed")
    places = _joined(columns, XYZ).astype(np.float64)
    if {*INDEX, "count", "cell_size"} <= columns.keys() and len(places):
        return _as_voxels(columns, places)
    return measured(cloud_in(columns))


def cloud_in(columns: Mapping[str, NDArray[Any]]) -> PointCloud:
    """The points of columns, each of them."""
    points = _joined(columns, XYZ).astype(np.float64)
    sigma = columns.get("sigma")
    return PointCloud(
        points=points,
        colours=_colours(columns, len(points)),
        sigma=None if sigma is None else sigma.astype(np.float64),
    )


def measured(cloud: PointCloud) -> PointCloud:
    """The points that are finite."""
    return cloud.select(np.flatnonzero(np.isfinite(cloud.points).all(axis=1)))


def _as_voxels(columns: Mapping[str, NDArray[Any]], means: NDArray[np.float64]) -> Voxels:
    cell_size = float(columns["cell_size"][0])
    index = _joined(columns, INDEX).astype(np.int64)
    kept: dict[str, Any] = {
        field: columns[name].astype(np.float64 if name == "weight" else np.int64)
        for name, field in _KEPT.items()
        if name in columns
    }
    if _HUES[0] in columns:
        kept["hues"] = _joined(columns, _HUES).astype(np.int64)
    return Voxels(
        index=index,
        centres=(index.astype(np.float64) + 0.5) * cell_size,
        means=means,
        counts=columns["count"].astype(np.int64),
        colours=_colours(columns, len(means)),
        cell_size=cell_size,
        **kept,
    )


def _colours(columns: Mapping[str, NDArray[Any]], num: int) -> NDArray[np.uint8]:
    if not set(RGB) <= columns.keys():
        return np.full((num, 3), 128, np.uint8)
    return _joined(columns, RGB).astype(np.uint8)


def _split(names: tuple[str, ...], values: NDArray[Any]) -> Columns:
    return dict(zip(names, values.T, strict=True))


def _joined(columns: Mapping[str, NDArray[Any]], names: tuple[str, ...]) -> NDArray[Any]:
    return np.column_stack([columns[name] for name in names])
