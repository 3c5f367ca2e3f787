"""A group of arrays as Zarr (version 3): a folder, one array a column."""

import secrets
import shutil
from pathlib import Path

import numpy as np

from recon.errors import InputError
from recon.exports.columns import Columns
from recon.libraries import load_extra


def write(path: Path, columns: Columns) -> None:
    """Write columns under their names; a Zarr group that stands there is replaced.

    Raises
    ------
    InputError
        Where something else stands there.
    """
    zarr = load_extra("zarr", "tables")
    if path.exists() and not (path / "zarr.json").is_file():
        raise InputError(f"{path} is there and no Zarr group, but a free name is needed")
    # A folder cannot take the place of another in one step: the old one is moved away first.
    mark = secrets.token_hex(4)
    new, old = (path.with_name(f".{mark}-{word}-{path.name}") for word in ("new", "old"))
    try:
        group = zarr.create_group(str(new))
        for name, values in columns.items():
            group.create_array(name, data=np.ascontiguousarray(values))
        if path.exists():
            path.replace(old)
        new.replace(path)
    finally:
        shutil.rmtree(new, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def read(path: Path) -> Columns:
    """The arrays of the group."""
    zarr = load_extra("zarr", "tables")
    try:
        group = zarr.open_group(str(path), mode="r")
        return {name: array[:] for name, array in group.arrays()}
    except (ValueError, KeyError, TypeError, RuntimeError, FileNotFoundError) as error:
        raise InputError(f"{path}: not a Zarr group ({error})") from error
