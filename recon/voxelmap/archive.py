"""The map's file format: columns of the cells, in index order, in an npz archive.

`numpy.load(path)` reads the columns by name. Nothing in it is ever unpickled.
"""

import io
import os
import sys
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, check_number, check_path, one_line
from recon.files import atomic_path, check_memory
from recon.records.clouds import GREY
from recon.voxelmap import hits
from recon.voxelmap.table import Rows

VERSION = 1

Columns = Mapping[str, NDArray[Any]]

_LEVEL = 4
"""Level of compression: a higher one takes twice as long for 2 % less, Bzip2 thrice for a tenth."""
_COPIES = 3.0
_MOST_ARRAYS = 2000
"""Maximum number of arrays in a file."""
_MAX_HEADER_BYTES = 1 << 16

# Errors of the zip and npy readers for a truncated or modified file.
_BROKEN = (
    zipfile.BadZipFile, zlib.error, EOFError, ValueError, KeyError, OSError, RuntimeError,
    OverflowError, SyntaxError, NotImplementedError, TypeError, tokenize.TokenError,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Content:
    """The content of a map's file."""

    cell_size: float
    ray_margin: float
    channels: tuple[str, ...]
    has_colour: bool
    rows: Rows
    """Hits, positions and colours of the cells."""
    columns: Columns
    """All arrays by name, for the channels."""


def hit_columns(rows: Rows, *, lean: bool, has_colour: bool) -> dict[str, NDArray[Any]]:
    """The arrays of ordered rows, stored as columns, which compress best."""
    # Differences wrap around in 32 bits, and so do the sums that undo them.
    index = rows["index"].view(np.uint32).T
    columns = {"index": np.diff(index, axis=1, prepend=np.uint32(0)), "count": rows["count"]}
    if not lean:
        columns["position"] = rows["position"].T
    if has_colour:
        columns["colour"] = (hits.mean_colours(rows) if lean else rows["colour"]).T
    return columns


def save(path: str | os.PathLike[str], columns: Columns) -> None:
    """Write arrays atomically; the same arrays yield the same bytes."""
    with (
        atomic_path(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive,
    ):
        for name, column in columns.items():
            # Red, green and blue of a cell are alike.
            array = np.asarray(column, order="F" if name.endswith("colour") else "C")
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)


def load(path: str | os.PathLike[str]) -> Content:
    """The content of a map's file.

    Raises
    ------
    InputError
        For a file that is truncated, of another version or inconsistent.
    """
    check_path(path)
    columns = read_columns(path)
    try:
        return _content(columns)
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(f"{path}: not a voxel map ({one_line(error)})") from error


def read_columns(path: str | os.PathLike[str]) -> dict[str, NDArray[Any]]:
    """All arrays of an npz archive; memory is allocated only for data actually in the file."""
    with Path(path).open("rb") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                entries = [one for one in archive.infolist() if one.filename.endswith(".npy")]
                _check_entries(path, entries)
                return {
                    entry.filename.removesuffix(".npy"): _read_entry(archive, entry)
                    for entry in entries
                }
        except _BROKEN as error:
            raise _not_whole(path, error) from error


def _check_entries(path: str | os.PathLike[str], entries: list[zipfile.ZipInfo]) -> None:
    if len(entries) > _MOST_ARRAYS:
        raise InputError(f"{len(entries)} arrays, but at most {_MOST_ARRAYS} are allowed")
    check_memory(path, _COPIES * sum(one.file_size for one in entries))


def read_array(path: str | os.PathLike[str]) -> NDArray[Any]:
    """The array of an npy file."""
    with Path(path).open("rb") as file:
        try:
            num_bytes = os.fstat(file.fileno()).st_size
            check_memory(path, _COPIES * num_bytes)
            return _read_array(file, Path(path).name, num_bytes)
        except _BROKEN as error:
            raise _not_whole(path, error) from error


def _not_whole(path: str | os.PathLike[str], error: Exception) -> InputError:
    if isinstance(error, InputError) and str(path) in str(error):
        return error
    return InputError(f"{path}: not a whole npz archive or npy file ({one_line(error)})")


def _read_entry(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(entry) as member:
        return _read_array(member, entry.filename, entry.file_size)


def _read_array(file: BinaryIO | Any, name: str, num_bytes: int) -> NDArray[Any]:
    shape, is_fortran, dtype = _read_header(file)
    claimed = int(np.prod(shape, dtype=object)) * dtype.itemsize
    # `read` allocates the requested size first, so a false claim must not reach it.
    data = file.read(min(claimed + 1, num_bytes, sys.maxsize))
    if len(data) != claimed:
        raise InputError(f"{name} claims {claimed} bytes, but holds {len(data)}")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if is_fortran else "C")


def _read_header(file: BinaryIO | Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0), (3, 0)):
        raise InputError("an array is of a newer npy version than 3.0")
    if version == (1, 0):
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(file)
    else:
        header = file if version == (2, 0) else _as_2_0(file)
        shape, is_fortran, dtype = np.lib.format.read_array_header_2_0(header)
    if dtype.hasobject:
        raise InputError(f"an array of {dtype} does not contain plain numbers")
    if min(shape, default=0) < 0:
        raise InputError(f"an array has shape {shape}")
    return shape, is_fortran, dtype


def _as_2_0(file: BinaryIO | Any) -> BinaryIO:
    """A header of version 3.0 in the form of 2.0: names in UTF-8 become escapes in ASCII."""
    length = int.from_bytes(file.read(4), "little")
    text = file.read(min(length, _MAX_HEADER_BYTES)).decode().encode("ascii", "backslashreplace")
    return io.BytesIO(len(text).to_bytes(4, "little") + text)


def _content(columns: Columns) -> Content:
    version = int(columns["version"])
    if version != VERSION:
        raise InputError(f"version {version}, but {VERSION} is needed")
    cell_size = float(columns["cell_size"])
    check_number("cell_size", cell_size, above=0)
    return Content(
        cell_size=cell_size,
        ray_margin=float(columns["ray_margin"]),
        channels=tuple(columns["channels"].tolist()),
        has_colour="colour" in columns,
        rows=rows_of(columns),
        columns=columns,
    )


def _check_cells(columns: Columns) -> None:
    """Check for integers, points in every cell, and unique cells in order."""
    num = columns["count"].size
    for name, shape in {"count": (num,), "index": (3, num), "position": (3, num)}.items():
        column = columns.get(name, np.zeros(shape, np.int64))
        if column.dtype.kind not in "iu" or column.shape != shape:
            raise InputError(f"{name} is not an array of {shape} integers")
    if num and columns["count"].min() < 1:
        raise InputError("its counts cannot come from points")
    index = np.cumsum(columns["index"], axis=1, dtype=np.uint32).view(np.int32).astype(np.int64)
    step = np.diff(index, axis=1)
    first = np.where(step[0] != 0, step[0], np.where(step[1] != 0, step[1], step[2]))
    if (first <= 0).any():
        raise InputError("its cells are not in order or not unique")


def rows_of(columns: Columns) -> Rows:
    """Hits, positions and colours of cells, from the arrays of `hit_columns`."""
    _check_cells(columns)
    count, position = columns["count"].astype(np.uint64), columns.get("position")
    is_lean = position is None
    if position is None:  # the cell centre
        position = np.broadcast_to(count * np.uint64(hits.STEPS // 2), (3, len(count)))
    colour = columns.get("colour")
    if colour is None:
        colour = np.broadcast_to(count * np.uint64(GREY), (3, len(count)))
    elif is_lean:  # the mean
        colour = colour * count
    is_wide = (count > hits.CAPACITY[hits.NARROW]).any()
    rows = np.zeros(len(count), hits.WIDE if is_wide else hits.NARROW)
    rows["index"] = np.cumsum(columns["index"], axis=1, dtype=np.uint32).T.view(np.int32)
    rows["count"] = count
    rows["position"] = position.T
    rows["colour"] = colour.T
    hits.check_sums(rows)
    return rows
