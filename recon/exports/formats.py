"""All formats by ending: one table, one function to write and one to read."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports import glb, las, nav2, npz, octomap, parquet, pcd, ply, vti, zarr
from recon.exports.columns import Columns, columns_of, from_columns
from recon.exports.turning import R_YUP_ZUP, R_ZUP_YUP, turned
from recon.records import PointCloud, Voxels
from recon.voxelmap import VoxelMap

Data = PointCloud | Voxels | VoxelMap
Box = tuple[Sequence[float], Sequence[float]]
"""Low and high corner (3,), world."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """How files of one ending are written and read."""

    write: Callable[[Path, Any], None]
    read: Callable[[Path], Data] | None
    """None where it holds neither a map nor a cloud."""
    up: Literal["y", "z"] = "y"
    """The axis that is up in the file."""
    takes: tuple[type, ...] = (PointCloud, Voxels)
    """What it is written of; of a map its cells are taken where it is not among these."""


def _table(module: Any, up: Literal["y", "z"] = "y") -> Format:
    """A format that holds named columns."""

    def write(path: Path, data: PointCloud | Voxels) -> None:
        columns: Columns = columns_of(data if up == "y" else turned(data, R_ZUP_YUP))
        module.write(path, columns)

    def read(path: Path) -> Data:
        columns = module.read(path)
        try:
            data = from_columns(columns)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        return data if up == "y" else turned(data, R_YUP_ZUP)

    return Format(write=write, read=read, up=up)


_LAS = _table(las, up="z")
_OCTOMAP = Format(write=octomap.write, read=octomap.read, up="z", takes=(Voxels, VoxelMap))
_NAV2 = Format(write=nav2.write, read=None, up="z", takes=(Voxels, VoxelMap))

FORMATS: Mapping[str, Format] = {
    ".ply": _table(ply),
    ".pcd": _table(pcd),
    ".las": _LAS,
    ".laz": _LAS,
    ".parquet": _table(parquet),
    ".zarr": _table(zarr),
    ".npz": Format(write=npz.write, read=npz.read, takes=(PointCloud, Voxels, VoxelMap)),
    ".vti": Format(write=vti.write, read=vti.read, takes=(Voxels,)),
    ".bt": _OCTOMAP,
    ".ot": _OCTOMAP,
    ".glb": Format(write=glb.write, read=None),
    ".pgm": _NAV2,
    ".yaml": _NAV2,
}


def format_of(path: str | Path) -> Format:
    """The format of an ending.

    Raises
    ------
    InputError
        For an ending that none has.
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise InputError(f"{path}: the ending {ending!r} is unknown; known are {' '.join(FORMATS)}")
    return FORMATS[ending]


def write(data: Data, path: str | Path, box: Box | None = None) -> None:
    """Write a cloud, cells or a map by the ending of `path`, whole or not at all.

    Formats of robots and surveyors (.las .laz .bt .ot .pgm) have z up; what is written there is
    turned: (x, y, z) becomes (x, -z, y).

    Parameters
    ----------
    data : PointCloud, Voxels or VoxelMap
        Of a map, all cells with a point.
    path : path
    box : (low, high), optional
        Only points, or cells whose middle, inside these corners (3,) of the world.

    Raises
    ------
    InputError
        For an unknown ending, or data that the format cannot hold.
    MissingLibraryError
        Where the library of the format is not installed.
    """
    form = format_of(path)
    if box is not None:
        data = _inside(data, *np.asarray(box, dtype=np.float64))
    if isinstance(data, VoxelMap) and VoxelMap not in form.takes:
        data = data.occupied(min_count=1)
    if not isinstance(data, form.takes):
        raise InputError(f"{path}: a format for cells cannot hold a cloud of points")
    form.write(Path(path), data)
    if form.up == "z":
        _log.info("%s has z up: (x, y, z) was written as (x, -z, y)", path)


def read(path: str | Path) -> Data:
    """Read a cloud, cells or a map, with y up, by the ending of `path`.

    Raises
    ------
    InputError
        For an unknown ending, one that holds neither, or a file that is not whole.
    MissingLibraryError
        Where the library of the format is not installed.
    """
    form = format_of(path)
    if form.read is None:
        raise InputError(f"{path}: holds neither a cloud nor a map that can be read back")
    if not Path(path).exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    return form.read(Path(path))


def _inside(data: Data, low: NDArray[np.float64], high: NDArray[np.float64]) -> Data:
    if isinstance(data, VoxelMap):
        return data.cropped(low, high)
    places = data.points if isinstance(data, PointCloud) else data.centres
    return data.select(np.flatnonzero(((places >= low) & (places <= high)).all(axis=1)))
