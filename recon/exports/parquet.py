"""A table of points or cells as Parquet, by pyarrow."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, one_line
from recon.exports.columns import Columns
from recon.exports.format import Format, table
from recon.exports.numbers import leave_out
from recon.files import PathLike, atomic_path, check_memory
from recon.libraries import load_extra


def write(path: Path, columns: Columns) -> None:
    """Write columns by name."""
    parquet = load_extra("pyarrow.parquet", "tables")
    with atomic_path(path) as temporary:
        parquet.write_table(_as_table(columns), temporary, compression="zstd")


def write_parts(path: Path, parts: Iterator[Columns], num: int) -> None:
    """Write columns in chunks, one row group per chunk."""
    parquet = load_extra("pyarrow.parquet", "tables")
    first = _as_table(next(parts))
    with (
        atomic_path(path) as temporary,
        parquet.ParquetWriter(temporary, first.schema, compression="zstd") as file,
    ):
        for content in itertools.chain([first], map(_as_table, parts)):
            file.write_table(content)


def _as_table(columns: Columns) -> Any:
    arrow = load_extra("pyarrow", "tables")
    return arrow.table({name: np.ascontiguousarray(v) for name, v in columns.items()})


def read(path: Path) -> Columns:
    """The numeric columns; missing values are NaN.

    Raises
    ------
    InputError
        If the file is truncated, or exceeds the memory limit when unpacked.
    """
    parquet, arrow = load_extra("pyarrow.parquet", "tables"), load_extra("pyarrow", "tables")
    try:
        with path.open("rb") as file:
            source = parquet.ParquetFile(file)
            check_size(source, path)
            found = source.read()
    except (arrow.ArrowException, OSError, ValueError, OverflowError, MemoryError) as error:
        raise InputError(f"not a whole Parquet file ({one_line(error)})") from error
    kept = [name for name in found.column_names if _is_number(arrow, found.schema.field(name))]
    leave_out([name for name in found.column_names if name not in kept], path)
    return {name: _values(arrow, found.column(name)) for name in kept}


def check_size(source: Any, path: PathLike) -> None:
    """Check the unpacked size; counts rows too, as a constant column packs to nearly nothing."""
    about = source.metadata
    groups = [about.row_group(n) for n in range(about.num_row_groups)]
    unpacked = sum(abs(one.total_byte_size) for one in groups)
    check_memory(path, 3.0 * max(unpacked, 8 * about.num_rows * about.num_columns))


def _is_number(arrow: Any, field: Any) -> bool:
    kinds = arrow.types
    tests = (kinds.is_integer, kinds.is_floating, kinds.is_boolean, kinds.is_decimal)
    return any(test(field.type) for test in tests)


def _values(arrow: Any, column: Any) -> NDArray[Any]:
    kinds = arrow.types
    if column.null_count or kinds.is_decimal(column.type) or kinds.is_float16(column.type):
        column = column.cast(arrow.float64())
    values: NDArray[Any] = column.to_numpy()
    return values


FORMAT: Format = table(read, write, write_parts=write_parts)
