"""A table of points or cells as Parquet, by pyarrow."""

from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.exports.columns import Columns
from recon.files import atomic_path
from recon.libraries import load_extra


def write(path: Path, columns: Columns) -> None:
    """Write columns under their names."""
    parquet, arrow = load_extra("pyarrow.parquet", "tables"), load_extra("pyarrow", "tables")
    table = arrow.table({name: np.ascontiguousarray(v) for name, v in columns.items()})
    with atomic_path(path) as temporary:
        parquet.write_table(table, temporary, compression="zstd")


def read(path: Path) -> Columns:
    """The columns of numbers."""
    parquet, arrow = load_extra("pyarrow.parquet", "tables"), load_extra("pyarrow", "tables")
    try:
        with path.open("rb") as file:
            table = parquet.read_table(file)
        return {name: table.column(name).to_numpy() for name in table.column_names}
    except arrow.ArrowException as error:
        raise InputError(f"{path}: not a whole Parquet file ({error})") from error
