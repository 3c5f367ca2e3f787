"""Cells as a VTK image: a dense block, every value an array of its cells."""

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.files import atomic_path
from recon.libraries import load_pyvista
from recon.records import Voxels
from recon.voxelmap.table import order_of

MAX_CELLS = 1 << 25
"""Of a block, so that a point gone astray far away does not take all memory and disk."""


_HEADER_BYTES = 1000


def write(path: Path, voxels: Voxels) -> None:
    """Write the block that the cells span; cells without points have count 0."""
    with atomic_path(path) as temporary:
        as_image(voxels).save(temporary)


def as_image(voxels: Voxels) -> Any:
    """The cells as a `pyvista.ImageData`, whose cell arrays are the fields of the record.

    Raises
    ------
    InputError
        Where they span more than MAX_CELLS.
    """
    span = voxels.index if len(voxels) else np.zeros((1, 3), np.int64)
    low = span.min(axis=0)
    shape = span.max(axis=0) - low + 1
    if np.prod(shape.astype(float)) > MAX_CELLS:
        raise InputError(
            f"the cells span {' x '.join(map(str, shape))}, but {MAX_CELLS} are the most for "
            "a dense block; give a box, or another format"
        )
    image = load_pyvista().ImageData(
        dimensions=shape + 1, spacing=[voxels.cell_size] * 3, origin=low * voxels.cell_size
    )
    place = np.ravel_multi_index(tuple((voxels.index - low).T), tuple(shape), order="F")
    for name, values in _fields(voxels).items():
        block = np.zeros((image.n_cells, *values.shape[1:]), values.dtype)
        block[place] = values
        image.cell_data[name] = block
    return image


def _fields(voxels: Voxels) -> dict[str, NDArray[Any]]:
    fields = {name: getattr(voxels, name) for name in Voxels.__slots__}
    return {
        name: values
        for name, values in fields.items()
        if isinstance(values, np.ndarray) and name not in ("index", "centres")
    }


def read(path: Path) -> Voxels:
    """The cells of a block that have points.

    Raises
    ------
    InputError
        Where the file is no VTK image with counts, means and colours of its cells.
    """
    _check_whole(path)
    try:
        with warnings.catch_warnings(action="error"):
            image = load_pyvista().read(path)
    except (UserWarning, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: VTK cannot read it") from error
    missing = [name for name in ("counts", "means", "colours") if name not in image.cell_data]
    if missing:
        raise InputError(f"{path}: its cells have no {missing[0]}")
    return of_image(image)


def _check_whole(path: Path) -> None:
    """VTK itself would say on the screen what is missing, and go on."""
    content = path.read_bytes()
    extent = re.search(rb'<ImageData WholeExtent="([-\d ]+)"', content[:_HEADER_BYTES])
    if extent is None or not content.rstrip().endswith(b"</VTKFile>"):
        raise InputError(f"{path}: not a whole VTK image")
    ends = [int(word) for word in extent[1].split()]
    num_cells = math.prod(high - low for low, high in zip(ends[::2], ends[1::2], strict=True))
    if num_cells > MAX_CELLS:
        raise InputError(f"{path}: claims {num_cells} cells, but {MAX_CELLS} are the most")


def of_image(image: Any) -> Voxels:
    """The cells with points of a `pyvista.ImageData` that `as_image` made."""
    cell_size = float(image.spacing[0])
    low = np.rint(np.array(image.origin) / cell_size).astype(np.int64)
    place = np.flatnonzero(image.cell_data["counts"])
    shape = np.array(image.dimensions) - 1
    index = low + np.column_stack(np.unravel_index(place, shape, order="F"))
    fields = {name: np.asarray(image.cell_data[name])[place] for name in image.cell_data}
    voxels = Voxels(
        index=index,
        centres=(index.astype(np.float64) + 0.5) * cell_size,
        cell_size=cell_size,
        **fields,
    )
    return voxels.select(order_of(index))
