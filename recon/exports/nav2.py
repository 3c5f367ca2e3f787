"""A map of the floor for nav2 and other planners of robots: `.pgm` and its `.yaml`; z up."""

from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from recon.errors import InputError, ReconError
from recon.files import atomic_path
from recon.records import GroundGrid, Voxels
from recon.voxelmap import VoxelMap
from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN, navigation
from recon.voxelmap.rays import Sightings

_GREYS = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}


def write(path: Path, data: Voxels | VoxelMap) -> None:
    """Write both files, whichever ending `path` has; free space is known of a map with rays.

    Raises
    ------
    InputError
        Where the band of heights of `navigation` holds nothing.
    """
    has_rays = isinstance(data, VoxelMap) and "rays" in data.channels
    sightings = data.sightings() if isinstance(data, VoxelMap) and has_rays else _NONE
    voxels = data.occupied(min_count=1) if isinstance(data, VoxelMap) else data
    floor = navigation(voxels, sightings)
    if not floor.cells.size:
        raise InputError(f"{path}: nothing of the map is at the height of a robot")
    _write_image(path.with_suffix(".pgm"), floor)
    _write_description(path.with_suffix(".yaml"), floor)


_NONE = Sightings(
    index=np.zeros((0, 3), np.int64), hits=np.zeros(0, np.int64), passes=np.zeros(0, np.int64)
)


def _write_image(path: Path, floor: GroundGrid) -> None:
    with atomic_path(path) as temporary:
        if not cv2.imwrite(str(temporary), image(floor)):
            raise ReconError(f"{path}: could not be written")


def image(floor: GroundGrid) -> NDArray[np.uint8]:
    """The floor as grey values (rows, columns): columns go along x, rows from small z on.

    With z up the second axis is -z, and it points up in the image.
    """
    greys = np.full(floor.cells.shape, _GREYS[UNKNOWN], np.uint8)
    for state, grey in _GREYS.items():
        greys[floor.cells == state] = grey
    return np.ascontiguousarray(greys.T)


def _write_description(path: Path, floor: GroundGrid) -> None:
    x, z = floor.origin_xz
    high_z = z + floor.cells.shape[1] * floor.cell_size
    description = {
        "image": path.with_suffix(".pgm").name,
        "mode": "trinary",
        "resolution": floor.cell_size,
        # Of the lower left pixel: the largest z, as the second axis is -z.
        "origin": [float(x), float(-high_z), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.25,
    }
    with atomic_path(path) as temporary:
        temporary.write_text(yaml.safe_dump(description, sort_keys=False), encoding="utf-8")
