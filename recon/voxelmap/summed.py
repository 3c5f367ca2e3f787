"""Lossless conversion of a voxel map to the ordered sums of its cells, and back."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap import archive, hits
from recon.voxelmap.coarse import MAX_LEVEL, coarse_columns
from recon.voxelmap.sums import COLOURS, HITS, CellSums, Index
from recon.voxelmap.table import CellTable, Rows
from recon.voxelmap.voxelmap import VoxelMap

EXTRAS = {"weight": ("weight",), "rays": ("hits", "passes"), "views": ()}
"""Names of the additional sums of each channel."""


def names_of(channels: tuple[str, ...], *, has_colour: bool) -> tuple[str, ...]:
    """Names of the sums of a map with these channels."""
    extras = tuple(name for channel in channels for name in EXTRAS[channel])
    return HITS + (COLOURS if has_colour else ()) + extras


def sums_of(voxel_map: VoxelMap) -> CellSums:
    """The sums of all cells of a map, including coarser ones."""
    columns = voxel_map.columns()
    names = names_of(voxel_map.channels, has_colour=voxel_map.has_colour)
    rows = archive.rows_of(columns)
    extra = {"weight": columns["weight"][:, 0]} if "weight" in columns else {}
    cells = _level(0, rows, names, extra)
    if "rays" in voxel_map.channels:
        cells += _of_rays(columns, names)
    levels = [cells]
    for level, coarse in enumerate(coarse_columns(columns), 1):
        if coarse:
            levels.append(_level(level, archive.rows_of(coarse), names, {}))
    return CellSums(
        index=np.concatenate([one.index for one in levels], axis=1),
        names=names,
        values=np.concatenate([one.values for one in levels], axis=1),
        views=_of_views(columns, rows),
    )


def _level(
    level: int, rows: Rows, names: tuple[str, ...], extra: dict[str, NDArray[np.uint64]]
) -> CellSums:
    own = [rows["count"], *rows["position"].T, *rows["colour"].T]
    known = dict(zip(HITS + COLOURS, own, strict=True)) | extra
    return _cells(
        level, rows["index"], {n: known.get(n, np.zeros(len(rows), np.uint64)) for n in names}
    )


def _cells(level: int, index: NDArray[np.integer], sums: dict[str, NDArray[Any]]) -> CellSums:
    levels = np.full(len(index), level)
    return CellSums(
        index=np.vstack([levels, index.T]).astype(np.int32),
        names=tuple(sums),
        values=np.array(list(sums.values()), np.uint64),
        views=np.zeros((4, 0), np.int32),
    )


def _of_rays(columns: archive.Columns, names: tuple[str, ...]) -> CellSums:
    """Hits and passes of the cells that scans touched, most of them without a point."""
    num = len(columns["ray_index"])
    sums = {n: columns.get(f"ray_{n}", np.zeros(num, np.uint64)) for n in names}
    return _cells(0, columns["ray_index"], sums)


def _of_views(columns: archive.Columns, rows: Rows) -> Index:
    if "view_cell" not in columns:
        return np.zeros((4, 0), np.int32)
    cells = rows["index"][columns["view_cell"]]
    return np.vstack([cells.T, columns["view"]]).astype(np.int32)


def map_of(
    cells: CellSums, cell_size: float, channels: tuple[str, ...], ray_margin: float
) -> VoxelMap:
    """The map with these sums.

    Raises
    ------
    InputError
        For sums that cannot result from points.
    """
    own = _chosen(cells, (cells.index[0] == 0) & (cells.sums["count"] > 0))
    columns = _hit_columns(own)
    if "weight" in channels:
        columns["weight"] = own.sums["weight"][:, None]
    if "rays" in channels:
        columns |= _ray_columns(cells)
    if "views" in channels:
        columns |= _view_columns(cells.views, own.index[1:])
    for level in range(1, MAX_LEVEL + 1):
        coarse = _chosen(cells, cells.index[0] == level)
        found = _hit_columns(coarse) if len(coarse) else {}
        columns |= {f"coarse{level}_{name}": values for name, values in found.items()}
    content = archive.Content(
        cell_size=cell_size,
        ray_margin=ray_margin,
        channels=channels,
        has_colour=cells.has_colour,
        rows=archive.rows_of(columns),
        columns=columns,
    )
    return VoxelMap.of(content)


def _chosen(cells: CellSums, mask: NDArray[np.bool_]) -> CellSums:
    return cells.select(np.flatnonzero(mask), np.zeros(0, np.int64))


def _hit_columns(cells: CellSums) -> dict[str, NDArray[Any]]:
    index = cells.index[1:].view(np.uint32)
    columns = {
        "index": np.diff(index, axis=1, prepend=np.uint32(0)),
        "count": cells.sums["count"],
        "position": cells.values[1:4],
    }
    return columns | ({"colour": cells.values[4:7]} if cells.has_colour else {})


def _ray_columns(cells: CellSums) -> dict[str, NDArray[Any]]:
    touched = _chosen(cells, (cells.sums["hits"] > 0) | (cells.sums["passes"] > 0))
    return {
        "ray_index": np.ascontiguousarray(touched.index[1:].T),
        "ray_hits": touched.sums["hits"],
        "ray_passes": touched.sums["passes"],
    }


def _view_columns(views: Index, cells: Index) -> dict[str, NDArray[Any]]:
    rows = np.zeros(cells.shape[1], hits.NARROW)
    rows["index"] = cells.T
    place = CellTable.of(rows).find(views[:3].T)
    if (place < 0).any() or (views[3] < 0).any():
        raise InputError("a view is below 0, or saw a cell without a point")
    return {"view_cell": place, "view": views[3].astype(np.int64)}
