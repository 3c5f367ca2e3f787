"""Cells as OctoMap trees, by pyoctomap: z up, `.bt` occupied or free, `.ot` also with colour."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, ReconError
from recon.exports.format import Format
from recon.exports.octomapfile import Header, check_whole
from recon.exports.turning import R_YUP_ZUP, R_ZUP_YUP, turned_index
from recon.files import atomic_path, check_memory
from recon.libraries import load_extra, silent
from recon.records import Voxels, cell_centres
from recon.voxelmap import VoxelMap
from recon.voxelmap.rays import log_odds
from recon.voxelmap.table import order_of

# Cells of a tree along an axis, on either side of 0.
_REACH = 1 << 15
_DEPTH = 16

_CELL_BYTES = 300.0
"""Memory per cell while leaves are split into cells and sorted."""

# OctoMap's log-odds of a cell after one hit, and its clamping limits.
_ONE_HIT = float(log_odds(np.ones(1, np.int64), np.zeros(1, np.int64))[0])
_LOWEST, _HIGHEST = -2.0, 3.5


def write(path: Path, data: Voxels | VoxelMap) -> None:
    """Write occupied cells; for a map that keeps rays, hit and passed cells by their log-odds.

    Raises
    ------
    InputError
        If a cell is more than 32768 cells from the origin, the limit of a tree.
    """
    octomap = load_extra("pyoctomap", "octomap")
    voxels = data.occupied(min_count=1) if isinstance(data, VoxelMap) else data
    index, values = voxels.index, np.full(len(voxels), _ONE_HIT)
    if isinstance(data, VoxelMap) and "rays" in data.channels:
        sightings = data.sightings()
        index, values = sightings.index, log_odds(sightings.hits, sightings.passes)
    has_colour = path.suffix.lower() == ".ot"
    tree = (octomap.ColorOcTree if has_colour else octomap.OcTree)(voxels.cell_size)
    for place, value in zip(_centres(index, voxels), values.clip(_LOWEST, _HIGHEST), strict=True):
        tree.updateNode(place, float(value), lazy_eval=True)
    if has_colour:
        for place, colour in zip(_centres(voxels.index, voxels), voxels.shown_colours, strict=True):
            tree.setNodeColor(place, *colour.tolist())
    # An empty tree has no root to update, which OctoMap does not check.
    if len(index):
        tree.updateInnerOccupancy()
    with atomic_path(path) as temporary:
        if not (tree.write if has_colour else tree.writeBinary)(str(temporary)):
            raise ReconError(f"{path}: OctoMap could not write it")
        _check_written(temporary, path, tree.size())


def _check_written(temporary: Path, path: Path, num_nodes: int) -> None:
    """Check the written file, since OctoMap does not report a full disk."""
    try:
        held = check_whole(temporary).num_nodes
    except InputError:
        held = -1
    if held != num_nodes:
        raise ReconError(f"{path}: OctoMap could not write it completely; is the disk full?")


def _centres(index: NDArray[np.int64], voxels: Voxels) -> NDArray[np.float64]:
    turned = turned_index(index, R_ZUP_YUP)
    if len(turned) and not (turned.min() >= -_REACH and turned.max() < _REACH):
        raise InputError(
            f"a cell is {np.abs(turned).max()} cells from the origin, but OctoMap's trees reach "
            f"{_REACH}; give a box"
        )
    return cell_centres(turned, voxels.cell_size)


def read(path: Path) -> Voxels:
    """The occupied cells, each with count 1; without colours if the tree has none.

    Raises
    ------
    InputError
        If the file is not a complete tree.
    """
    octomap = load_extra("pyoctomap", "octomap")
    header = check_whole(path)
    leaves = np.array(_occupied_leaves(octomap, path, header) if header.num_nodes else []).reshape(
        -1, 7
    )
    num_cells = float((np.rint(leaves[:, 3] / header.cell_size) ** 3).sum())
    check_memory(path, _CELL_BYTES * num_cells)
    found = _voxels(leaves, header.cell_size)
    return found if header.kind == "ColorOcTree" else replace(found, colours=None)


def _occupied_leaves(octomap: Any, path: Path, header: Header) -> list[tuple[float, ...]]:
    """Centre, side and colour of each: x, y, z, side, red, green, blue."""
    has_colour = header.kind == "ColorOcTree"
    tree = (octomap.ColorOcTree if has_colour else octomap.OcTree)(header.cell_size)
    with silent():
        if path.suffix.lower() == ".bt":
            is_read = bool(tree.readBinary(str(path)))
        else:
            tree = tree.read(str(path))
            is_read = tree is not None
    if not is_read:
        raise InputError("not a whole OctoMap file (OctoMap cannot read it)")
    return [
        (
            *leaf.getCoordinate(),
            leaf.getSize(),
            *(leaf.current_node.getColor() if has_colour else (0, 0, 0)),
        )
        for leaf in tree.begin_leafs(_DEPTH)
        if tree.isNodeOccupied(leaf.current_node)
    ]


def _voxels(leaves: NDArray[np.float64], cell_size: float) -> Voxels:
    index, colours = _expanded(leaves, cell_size)
    index = turned_index(index, R_YUP_ZUP)
    return Voxels.occupied(index, cell_size, colours).select(order_of(index))


def _expanded(
    leaves: NDArray[np.float64], cell_size: float
) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Index and colour of every smallest cell: a leaf may represent a cube of them."""
    sides = np.rint(leaves[:, 3] / cell_size).astype(np.int64)
    low = np.rint(leaves[:, :3] / cell_size - sides[:, None] / 2).astype(np.int64)
    index, rows = [], []
    for side in np.unique(sides).tolist():
        chosen = np.flatnonzero(sides == side)
        inside = np.indices((side, side, side)).reshape(3, -1).T
        index.append((low[chosen, None] + inside).reshape(-1, 3))
        rows.append(np.repeat(chosen, side**3))
    if not index:
        return np.zeros((0, 3), np.int64), np.zeros((0, 3), np.uint8)
    return np.concatenate(index), leaves[np.concatenate(rows), 4:].astype(np.uint8)


FORMAT = Format(write=write, read=read, up="z", takes=(Voxels, VoxelMap))
