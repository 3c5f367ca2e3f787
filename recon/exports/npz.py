"""Maps, cells and points as numpy's npz, and points as its npy."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.arrays import columns_in
from recon.exports.columns import XYZ, cloud_in, columns_of, measured
from recon.exports.format import Format
from recon.exports.numbers import drop_columns
from recon.files import atomic_path
from recon.records import PointCloud, Voxels
from recon.voxelmap import VoxelMap, archive

Data = PointCloud | Voxels | VoxelMap

_OWN = {field.name for field in fields(PointCloud)}


def write(path: Path, data: Data) -> None:
    """Write a map losslessly; for cells and points, the fields of the record by name."""
    if isinstance(data, VoxelMap):
        data.save(path)
        return
    if isinstance(data, PointCloud) and data.crs is not None:
        drop_columns(["the coordinate reference system"], path)
    arrays = {
        name: np.asarray(value)
        for name in type(data).__slots__
        if (value := getattr(data, name)) is not None and name not in ("attributes", "crs")
    }
    if isinstance(data, PointCloud):
        arrays |= {name: v for name, v in data.attributes.items() if name not in _OWN}
    archive.save(path, arrays)


def read(path: Path) -> Data:
    """A map, cells or points, distinguished by the names of the arrays.

    Raises
    ------
    InputError
        If the arrays are none of these.
    """
    columns = archive.read_columns(path)
    if "version" in columns and "channels" in columns:
        return VoxelMap.load(path)
    try:
        if "counts" in columns and "index" in columns:
            kept: dict[str, Any] = {n: columns[n] for n in Voxels.__slots__ if n in columns}
            return Voxels(**kept | {"cell_size": float(columns["cell_size"])})
        return measured(cloud_in(columns_in(columns)))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"neither a map nor a cloud ({error})") from error


def read_npy(path: Path) -> PointCloud:
    """The points of one array (N, 3 or more), or of one with named fields.

    Raises
    ------
    InputError
        If it is truncated, or contains anything but numbers.
    """
    array = archive.read_array(path)
    if array.dtype.names:
        return measured(cloud_in(columns_in({n: array[n].reshape(-1) for n in array.dtype.names})))
    if array.ndim == 3 and array.shape[2] >= len(XYZ):
        array = array.reshape(-1, array.shape[2])
    # Unnamed, so that an image is not a cloud.
    return measured(cloud_in(columns_in({"array": array})))


def write_npy(path: Path, data: PointCloud | Voxels) -> None:
    """Write rows with named fields."""
    columns = columns_of(data)
    rows = np.empty(len(data), [(name, values.dtype) for name, values in columns.items()])
    for name, values in columns.items():
        rows[name] = values
    # Chosen here, since numpy warns when it chooses 3.0 for names beyond Latin-1.
    version = (1, 0) if all(map(str.isascii, columns)) else (3, 0)
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        np.lib.format.write_array(file, rows, version, allow_pickle=False)


FORMAT = Format(write=write, read=read, takes=(PointCloud, Voxels, VoxelMap))
NPY = Format(write=write_npy, read=read_npy)
