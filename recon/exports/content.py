"""The content of a file: a map or points, how much of it there is, and what a box holds of it."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypeIs

from recon.errors import as_numbers, check_shape
from recon.exports.format import Data
from recon.files import PathLike
from recon.notices import notify
from recon.records import Mesh, PointCloud

if TYPE_CHECKING:  # maps bring their kernels, which tables of points do without
    from recon.exports.partitions.partitioned import PartitionedMap
    from recon.voxelmap import VoxelMap

Box = tuple[Sequence[float], Sequence[float]]
"""Low and high corner (3,), world."""


def is_map(data: "Data | PartitionedMap") -> "TypeIs[VoxelMap]":
    """Test for a map; if its package is not loaded yet, there are none."""
    module = sys.modules.get("recon.voxelmap")
    return module is not None and isinstance(data, module.VoxelMap)


def is_in_partitions(data: "Data | PartitionedMap") -> "TypeIs[PartitionedMap]":
    """Test for a partitioned map."""
    module = sys.modules.get("recon.exports.partitions.partitioned")
    return module is not None and isinstance(data, module.PartitionedMap)


def len_of(data: "Data | PartitionedMap") -> int:
    """Number of points, cells or triangles."""
    return data.num_cells if is_map(data) or is_in_partitions(data) else len(data)


def inside(data: "Data | PartitionedMap", box: Box, path: PathLike) -> Data:
    """The part inside a box, to be written to `path`; a notice says if there is none.

    Raises
    ------
    InputError
        Unless the box has two corners.
    """
    corners = as_numbers("box", box)
    check_shape("box", corners, (2, 3))
    kept = _inside(data.within(box) if is_in_partitions(data) else data, *corners)
    if not len_of(kept):
        notify("box-empty", f"{path}: nothing lies inside the box")
    return kept


@overload
def _inside(data: "VoxelMap", low: Any, high: Any) -> "VoxelMap": ...


@overload
def _inside(data: Data, low: Any, high: Any) -> Data: ...


def _inside(data: Data, low: NDArray[np.float64], high: NDArray[np.float64]) -> Data:
    if is_map(data):
        return data.cropped(low, high)
    if isinstance(data, Mesh):
        is_kept: Any = ((data.vertices >= low) & (data.vertices <= high)).all(axis=1)
        return data.select(np.flatnonzero(is_kept[data.triangles].all(axis=1)))
    places = data.points if isinstance(data, PointCloud) else data.centres
    return data.select(np.flatnonzero(((places >= low) & (places <= high)).all(axis=1)))
