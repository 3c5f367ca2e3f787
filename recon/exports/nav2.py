"""A floor map for nav2 and other robot planners: `.pgm` and its `.yaml`; z up."""

import math
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.format import Format
from recon.files import atomic_path, check_memory, check_regular
from recon.files.documents import read_yaml
from recon.records import GroundGrid, Voxels
from recon.voxelmap import VoxelMap
from recon.voxelmap.ground import BAND, FREE, OCCUPIED, UNKNOWN, navigation
from recon.voxelmap.rays import Sightings

_GREYS = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}
_NONE = Sightings(
    index=np.zeros((0, 3), np.int64), hits=np.zeros(0, np.int64), passes=np.zeros(0, np.int64)
)

_ROUNDING = 1e-6
"""Of a pixel: centres on a border belong to one."""
_MAX_SIZE = 1e9
"""Of a pixel, world units; its inverse is the smallest."""
_MAX_PIXELS = 1 << 31
"""Distance of the origin."""


def write(path: Path, data: Voxels | VoxelMap) -> None:
    """Write both files, whichever suffix `path` has; free space needs a map with rays.

    Raises
    ------
    InputError
        If the map has no cells in the height band of `navigation`.
    """
    has_rays = isinstance(data, VoxelMap) and "rays" in data.channels
    sightings = data.sightings() if isinstance(data, VoxelMap) and has_rays else _NONE
    voxels = data.occupied(min_count=1) if isinstance(data, VoxelMap) else data
    floor = navigation(voxels, sightings)
    if not floor.cells.size:
        raise InputError(f"{path}: nothing of the map is at the height of a robot")
    _write_image(path.with_suffix(".pgm"), floor)
    is_image = path.suffix.lower() == ".pgm"
    _write_description(path.with_suffix(".yaml") if is_image else path, floor)


def _write_image(path: Path, floor: GroundGrid) -> None:
    greys = image(floor)
    with atomic_path(path) as temporary:
        head = f"P5\n{greys.shape[1]} {greys.shape[0]}\n255\n"
        temporary.write_bytes(head.encode() + greys.tobytes())


def image(floor: GroundGrid) -> NDArray[np.uint8]:
    """The floor as grey values (rows, columns): columns along x, rows along z.

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
        # Origin of the lower left pixel: the largest z, as the second axis is -z.
        "origin": [float(x), float(-high_z), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.25,
    }
    with atomic_path(path) as temporary:
        temporary.write_text(yaml.safe_dump(description, sort_keys=False), encoding="utf-8")


def read(path: Path) -> Voxels:
    """The occupied cells, each with count 1, in one layer at the height of a robot.

    A cell takes the pixel that contains its centre, as the image need not be aligned with the
    world's grid; free and unknown floor is not kept.

    Raises
    ------
    InputError
        If the description lacks a number, or the image is damaged.
    """
    is_image = path.suffix.lower() == ".pgm"
    description = _description(_description_of(path) if is_image else path)
    greys = _read_image(path if is_image else path.parent / description["image"])
    shares = (greys if description["negate"] else 255 - greys.astype(np.int64)) / 255.0
    size = description["resolution"]
    cells = _floor_cells(shares > description["occupied_thresh"], description["origin"], size)
    height = math.ceil(BAND[0] / size - 0.5)
    index = np.column_stack([cells[:, 0], np.full(len(cells), height), cells[:, 1]])
    return Voxels.occupied(index, size)


def _floor_cells(
    is_occupied: NDArray[np.bool_], origin: list[float], size: float
) -> NDArray[np.int64]:
    """(K, 2) indices along x and z, in order, of the cells whose centre lies in such a pixel.

    Parameters
    ----------
    is_occupied : (rows, columns)
    origin : [x, y, yaw]
        Of the corner of the lower left pixel, with z up; yaw in radians, 0 where left out.
    size : float
        Of a cell and a pixel, world units.
    """
    row, column = np.nonzero(is_occupied)
    if not len(row):
        return np.zeros((0, 2), np.int64)
    num_rows = len(is_occupied)
    yaw = origin[2] if len(origin) > 2 else 0.0
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    low, high = [column.min(), num_rows - 1 - row.max()], [column.max(), num_rows - 1 - row.min()]
    corners = np.array([*product(*zip(low, np.add(high, 1), strict=True))]) @ turn.T
    # The second axis of a format with z up is -z of the world.
    ends = (corners + np.divide(origin[:2], size)) * [1, -1]
    x, z = (np.arange(math.floor(values.min()), math.ceil(values.max()) + 1) for values in ends.T)
    cells = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    middles = ((cells + 0.5) * [1, -1] - np.divide(origin[:2], size)) @ turn
    pixel = np.floor(middles + np.array([-_ROUNDING, _ROUNDING])).astype(np.int64)
    inside = ((pixel >= low) & (pixel <= high)).all(axis=1)
    found = np.flatnonzero(inside)
    across, up = pixel[found].T
    chosen: NDArray[np.int64] = cells[found[is_occupied[num_rows - 1 - up, across]]]
    return chosen


def _description_of(image_path: Path) -> Path:
    """The description beside an image."""
    found = [image_path.with_suffix(s) for s in (".yaml", ".yml")]
    for path in found:
        if path.is_file():
            return path
    raise InputError(f"{image_path}: its description {found[0].name} is not beside it")


def _description(path: Path) -> dict[str, Any]:
    """The numbers of a description, with nav2's defaults for missing ones."""
    check_regular(path)
    content = read_yaml(path)
    try:
        found: dict[str, Any] = {
            "image": str(content["image"]),
            "resolution": float(content["resolution"]),
            "origin": [float(value) for value in content["origin"]],
            "negate": int(content.get("negate", 0)),
            "occupied_thresh": float(content.get("occupied_thresh", 0.65)),
        }
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: not the description of a nav2 map ({error!r})") from error
    origin = found["origin"]
    size = found["resolution"]
    is_near = len(origin) >= 2 and all(abs(value) <= _MAX_PIXELS * size for value in origin[:2])
    # Written so that NaN fails too.
    if not (1.0 / _MAX_SIZE <= size <= _MAX_SIZE and is_near and np.isfinite(origin).all()):
        raise InputError(f"{path}: resolution is {size}, origin {origin}")
    if Path(found["image"]).is_absolute() or ".." in Path(found["image"]).parts:
        raise InputError(f"{path}: its image {found['image']!r} lies outside its folder")
    return found


def _read_image(path: Path) -> NDArray[np.uint8]:
    check_regular(path)
    content = np.fromfile(path, np.uint8)
    check_memory(path, 100.0 * len(content))
    try:
        greys = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE)
    except cv2.error:
        greys = None
    if greys is None:
        raise InputError(f"{path}: not a whole image")
    return np.asarray(greys, np.uint8)


FORMAT = Format(write=write, read=read, up="z", takes=(Voxels, VoxelMap))
