"""One partition as a Parquet file: a row per cell with the sums over its points."""

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, one_line
from recon.exports.parquet import check_size
from recon.libraries import load_extra
from recon.voxelmap import hits
from recon.voxelmap.coarse import MAX_LEVEL
from recon.voxelmap.sums import CellSums, at_most, is_ordered

INDEX = ("level", "index_x", "index_y", "index_z")
VIEWS = "views"
WHOLE = ("count", "hits", "passes")
"""Names of the counts."""
MAX_SUM = hits.CAPACITY[hits.WIDE]


def to_parquet(cells: CellSums, *, keeps_views: bool) -> bytes:
    """The file content for some cells; the same cells yield the same bytes."""
    parquet, arrow = load_extra("pyarrow.parquet", "tables"), load_extra("pyarrow", "tables")
    columns = dict(zip(INDEX, cells.index, strict=True)) | dict(cells.sums)
    content = {name: arrow.array(values) for name, values in columns.items()}
    if keeps_views:
        rows = _rows_of_views(cells)
        ends = np.cumsum(np.bincount(rows, minlength=len(cells)))
        offsets = np.concatenate([[0], ends]).astype(np.int32)
        content[VIEWS] = arrow.ListArray.from_arrays(offsets, arrow.array(cells.views[3]))
    stream = io.BytesIO()
    # Sums are practically random numbers of few bits: packing them is fast, and then neither a
    # dictionary nor compression makes them smaller.
    packed = dict.fromkeys([*columns, f"{VIEWS}.list.element"], "DELTA_BINARY_PACKED")
    # Without gaps, which need not be looked for then.
    fields = [arrow.field(name, one.type, nullable=False) for name, one in content.items()]
    table = arrow.table(list(content.values()), arrow.schema(fields))
    parquet.write_table(
        table, stream, compression="none", use_dictionary=False,
        column_encoding=packed, write_statistics=False,
    )  # fmt: skip
    return stream.getvalue()


def _rows_of_views(cells: CellSums) -> NDArray[np.int64]:
    """(P,) row of the cell of each view: both are in cell order."""
    begins = np.ones(cells.views.shape[1], np.bool_)
    begins[1:] = (np.diff(cells.views[:3], axis=1) != 0).any(axis=0)
    is_seen = (cells.index[0] == 0) & (cells.sums["count"] > 0)
    rows: NDArray[np.int64] = np.flatnonzero(is_seen)[np.cumsum(begins) - 1]
    return rows


def from_parquet(content: bytes, names: tuple[str, ...], *, keeps_views: bool) -> CellSums:
    """The cells of a file.

    Raises
    ------
    InputError
        If it is truncated, lacks a column, or has sums that cannot result from points.
    """
    parquet, arrow = load_extra("pyarrow.parquet", "tables"), load_extra("pyarrow", "tables")
    wanted = [*INDEX, *names, *([VIEWS] if keeps_views else [])]
    try:
        source = parquet.ParquetFile(arrow.BufferReader(content))
        check_size(source, "it")
        missing = set(wanted) - set(source.schema_arrow.names)
        if missing:
            raise InputError(f"it lacks the columns {', '.join(sorted(missing))}")
        table = source.read(columns=wanted, use_threads=False).combine_chunks()
        cells = _cells(table, names, keeps_views)
    except (arrow.ArrowException, OSError, ValueError, OverflowError, MemoryError) as error:
        raise InputError(f"not a whole partition ({one_line(error)})") from error
    _check(cells)
    return cells


def _cells(table: Any, names: tuple[str, ...], keeps_views: bool) -> CellSums:
    index = np.vstack([_whole(table, name) for name in INDEX])
    if len(table) and not (index.min() >= -(2**31) and index.max() < 2**31):
        raise InputError("its cells are out of reach")
    index = index.astype(np.int32, copy=False)
    return CellSums(
        index=index,
        names=names,
        values=np.array([_whole(table, name) for name in names], np.uint64),
        views=_views(table, index) if keeps_views else np.zeros((4, 0), np.int32),
    )


def _whole(table: Any, name: str) -> NDArray[Any]:
    values = table.column(name)
    if values.null_count:
        raise InputError(f"its {name} has gaps")
    array: NDArray[Any] = values.to_numpy()
    if array.dtype.kind not in "iu" or (array.dtype == np.uint64 and name in INDEX):
        raise InputError(f"its {name} is {array.dtype}, but whole numbers are needed")
    if array.dtype.kind == "i" and name not in INDEX and array.min(initial=0) < 0:
        raise InputError(f"its {name} holds numbers below 0")
    return array


def _views(table: Any, index: NDArray[np.int32]) -> NDArray[np.int32]:
    if not len(table):
        return np.zeros((4, 0), np.int32)
    lists = table.column(VIEWS).chunk(0)
    lists.validate(full=True)
    if lists.null_count or lists.values.null_count:
        raise InputError("its views have gaps")
    rows = np.repeat(np.arange(len(table)), lists.value_lengths().to_numpy())
    views = lists.flatten().to_numpy().astype(np.int32, casting="same_kind", copy=False)
    return np.vstack([index[1:, rows], views])


def _check(cells: CellSums) -> None:
    """Raise `InputError` for cells that no map can produce."""
    if not (is_ordered(cells.index) and is_ordered(cells.views)):
        raise InputError("its cells are not in order or not unique")
    level = cells.index[0]
    if level.min(initial=0) < 0 or level.max(initial=0) > MAX_LEVEL:
        raise InputError(f"a level is not one of 0 to {MAX_LEVEL}")
    for name, values in cells.sums.items():
        if not _can_be(name, values, cells.sums["count"]):
            raise InputError(f"its {name} cannot come from points")


def _can_be(name: str, values: NDArray[np.uint64], counts: NDArray[np.uint64]) -> bool:
    """True for sums that points can add up to; hits and passes are not sums over points."""
    if name in WHOLE:
        return bool(values.max(initial=0) <= MAX_SUM)
    each = 255 if name.startswith("colour") else hits.STEPS - (name != "weight")
    return at_most(values, counts, each)
