"""Maps, cells and points as numpy's npz."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.columns import measured
from recon.records import PointCloud, Voxels
from recon.voxelmap import VoxelMap, archive

Data = PointCloud | Voxels | VoxelMap

# What the arrays of points are called, by us and by others.
_POINTS = ("points", "xyz")
_COLOURS = ("colours", "colors", "rgb")


def write(path: Path, data: Data) -> None:
    """Write a map exactly; of cells and points, the fields of the record under their names."""
    if isinstance(data, VoxelMap):
        data.save(path)
        return
    fields = {name: getattr(data, name) for name in type(data).__slots__}
    archive.save(path, {name: np.asarray(v) for name, v in fields.items() if v is not None})


def read(path: Path) -> Data:
    """A map, cells or points, told apart by the names of the arrays.

    Raises
    ------
    InputError
        Where the arrays are none of these.
    """
    columns = archive.read_columns(path)
    if "version" in columns:
        return VoxelMap.load(path)
    try:
        if "counts" in columns:
            fields: dict[str, Any] = {n: columns[n] for n in Voxels.__slots__ if n in columns}
            return Voxels(**fields | {"cell_size": float(columns["cell_size"])})
        return _cloud(columns)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: neither a map nor a cloud ({error})") from error


def _cloud(columns: archive.Columns) -> PointCloud:
    points = next((columns[name] for name in _POINTS if name in columns), None)
    if points is None:
        raise InputError(f"its arrays are {', '.join(columns)}, but points is needed")
    grey = np.full((len(points), 3), 128, np.uint8)
    colours = next((columns[name] for name in _COLOURS if name in columns), grey)
    return measured(
        PointCloud(points=points.astype(np.float64), colours=colours, sigma=columns.get("sigma"))
    )
