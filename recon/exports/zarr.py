"""A group of arrays as Zarr (version 3): a folder with one array per column."""

import contextlib
import math
import re
import secrets
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, one_line
from recon.exports.arrays import columns_in
from recon.exports.columns import Columns
from recon.exports.format import Format, table
from recon.exports.names import spelled
from recon.files import check_memory, check_regular
from recon.libraries import load_extra

_MAX_NAME_BYTES = 255


def write(path: Path, columns: Columns) -> None:
    """Write columns by name; an existing Zarr group is replaced.

    Raises
    ------
    InputError
        If `path` is something else.
    """
    zarr = load_extra("zarr", "tables")
    if path.exists() and not (path / "zarr.json").is_file():
        raise InputError(f"{path} exists and is not a Zarr group, but a free name is needed")
    # A folder cannot replace another atomically: the old one is moved away first.
    mark = secrets.token_hex(4)
    new, old = (path.with_name(f".{mark}-{word}-{path.name}") for word in ("new", "old"))
    try:
        # Zeros are written too, so that a missing chunk is a lost one.
        with zarr.config.set({"array.write_empty_chunks": True}):
            group = zarr.create_group(str(new))
            for name, values in spelled(columns, _node_name, path).items():
                group.create_array(name, data=np.ascontiguousarray(values))
        if path.exists():
            path.replace(old)
        new.replace(path)
    except OSError as error:
        # Zarr's own errors name no file.
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        if old.exists() and not path.exists():
            old.replace(path)
        shutil.rmtree(new, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def _node_name(name: str) -> str:
    """The name of a node: none of a path, none that Zarr reserves; empty if too long for a file."""
    node = re.sub(r"/|^__|^\.+$", "_", name)
    return node if len(node.encode()) <= _MAX_NAME_BYTES else ""


def read(path: Path) -> Columns:
    """The arrays of the group.

    Raises
    ------
    InputError
        If a chunk is missing, or arrays exceed the memory limit.
    """
    zarr = load_extra("zarr", "tables")
    if not path.is_dir():
        raise InputError("not a Zarr group (it is a file)")
    for part in path.rglob("*"):
        if not part.is_dir():
            check_regular(part)
    try:
        with contextlib.closing(zarr.open_group(str(path), mode="r").store) as store:
            arrays = dict(zarr.open_group(store, mode="r").arrays())
            check_memory(path, 3.0 * sum(_num_bytes(array) for array in arrays.values()))
            return columns_in({name: _values(array) for name, array in arrays.items()})
    except InputError:
        raise
    # Zarr raises errors without a common base class for damaged folders.
    except Exception as error:
        raise InputError(f"not a whole Zarr group ({one_line(error)})") from error


def _num_bytes(array: Any) -> float:
    return float(math.prod(array.shape) * array.dtype.itemsize)


def _values(array: Any) -> NDArray[Any]:
    if min(array.chunks, default=1) < 1:
        raise InputError(f"{array.basename} has chunks of {array.chunks}")
    if array.nchunks > array.size + 1 or array.nchunks_initialized < array.nchunks:
        raise InputError(
            f"{array.basename} has {array.nchunks_initialized} of {array.nchunks} chunks"
        )
    values: NDArray[Any] = np.asarray(array[:])
    return values


FORMAT: Format = table(read, write)
