"""A floor map for nav2 and other robot planners: `.pgm` and its `.yaml`; z up."""

import math
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
from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN, navigation
from recon.voxelmap.rays import Sightings

_GREYS = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}


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


_NONE = Sightings(
    index=np.zeros((0, 3), np.int64), hits=np.zeros(0, np.int64), passes=np.zeros(0, np.int64)
)


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

    A grid that is not aligned with the world's is shifted by less than half a cell; free and
    unknown floor is not kept.

    Raises
    ------
    InputError
        If the description lacks a number, or the image is damaged.
    """
    is_image = path.suffix.lower() == ".pgm"
    description = _description(_description_of(path) if is_image else path)
    greys = _read_image(path if is_image else path.parent / description["image"])
    shares = (greys if description["negate"] else 255 - greys.astype(np.int64)) / 255.0
    row, column = np.nonzero(shares > description["occupied_thresh"])
    size = description["resolution"]
    x, y = description["origin"][:2]
    # Rows go down, and the second axis of a format with z up is the world's -z.
    ground = np.column_stack(
        [x + (column + 0.5) * size, -(y + (greys.shape[0] - row - 0.5) * size)]
    )
    cells = np.floor(ground / size + _ROUNDING).astype(np.int64)
    height = math.ceil(_LOWEST / size - 0.5)
    index = np.unique(
        np.column_stack([cells[:, 0], np.full(len(cells), height), cells[:, 1]]), axis=0
    )
    centres = (index + 0.5) * size
    colours = np.full((len(index), 3), _GREYS[OCCUPIED], np.uint8)
    return Voxels(
        index=index, centres=centres, means=centres, counts=np.ones(len(index), np.int64),
        colours=colours, cell_size=size,
    )  # fmt: skip


_LOWEST = 0.5
"""Minimum height of an obstacle, as in `navigation`."""
_ROUNDING = 1e-6


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
    if not (0 < found["resolution"] < math.inf and len(origin) >= 2 and np.isfinite(origin).all()):
        raise InputError(f"{path}: resolution is {found['resolution']}, origin {origin}")
    if any(origin[2:]):
        raise InputError(f"{path}: its origin is rotated by {origin[2]}, but 0 is needed")
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
