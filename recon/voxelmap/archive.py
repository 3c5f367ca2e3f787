"""The map's file: columns of the cells in the order of their index, in an npz archive."""

import os
import zipfile
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.files import atomic_path
from recon.voxelmap import hits
from recon.voxelmap.table import Rows

VERSION = 1


def save(path: str | os.PathLike[str], rows: Rows, cell_size: float) -> None:
    """Write ordered rows, whole or not at all."""
    columns: dict[str, Any] = {name: rows[name] for name in hits.NARROW.names or ()}
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, version=VERSION, cell_size=cell_size, **columns)


def load(path: str | os.PathLike[str]) -> tuple[Rows, float]:
    """The rows of a file, and the size of its cells."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if int(archive["version"]) != VERSION:
                raise InputError(f"{path}: version {archive['version']}, but {VERSION} is needed")
            wide = archive["position"].dtype.itemsize == 8
            rows = np.zeros(len(archive["index"]), hits.WIDE if wide else hits.NARROW)
            for name in rows.dtype.names or ():
                rows[name] = archive[name]
            return rows, float(archive["cell_size"])
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not a whole voxel map ({error})") from error
