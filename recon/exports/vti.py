"""Cells as a VTK image: a dense block with an array for every value."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, ReconError
from recon.exports.format import Format
from recon.exports.vtk import read_dataset, read_points
from recon.files import atomic_path
from recon.libraries import load_pyvista, silent
from recon.records import PointCloud, Voxels, cell_centres

MAX_CELLS = 1 << 25
"""Limit of a block: a single far outlier must not exhaust memory and disk."""


_HEADER_BYTES = 1000
_EXTENT = re.compile(rb'<ImageData[^>]*WholeExtent="' + rb" +".join([rb"(-?\d+)"] * 6) + rb' *"')


def write(path: Path, voxels: Voxels) -> None:
    """Write the block that the cells span; cells without points have count 0."""
    image = as_image(voxels)
    with atomic_path(path) as temporary:
        with silent():
            image.save(temporary)
        _check_written(temporary, path, image)


def _check_written(temporary: Path, path: Path, image: Any) -> None:
    """Check the written file, since VTK does not report a full disk."""
    try:
        _check_whole(temporary)
        again = read_dataset(temporary)
        is_same = all(
            np.array_equal(again.cell_data[name], image.cell_data[name]) for name in image.cell_data
        )
    except (InputError, KeyError, FileNotFoundError):
        is_same = False
    if not is_same:
        raise ReconError(f"{path}: VTK could not write it completely; is the disk full?")


def as_image(voxels: Voxels) -> Any:
    """The cells as a `pyvista.ImageData`, whose cell arrays are the fields of the record.

    Raises
    ------
    InputError
        If they span more than MAX_CELLS.
    """
    span = voxels.index if len(voxels) else np.zeros((1, 3), np.int64)
    low = span.min(axis=0)
    shape = span.max(axis=0) - low + 1
    if np.prod(shape.astype(float)) > MAX_CELLS:
        raise InputError(
            f"the cells span {' x '.join(map(str, shape))}, but at most {MAX_CELLS} fit "
            "into a dense block; give a box, or another format"
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


def read(path: Path) -> PointCloud | Voxels:
    """The cells of a block that have points; for other programs' blocks, positions with a value.

    Raises
    ------
    InputError
        If the file is not a whole VTK image.
    """
    _check_whole(path)
    image = read_dataset(path)
    if not {"counts", "means"} <= set(image.cell_data.keys()):
        return read_points(path)
    _check_cells(image)
    return of_image(image)


def _check_cells(image: Any) -> None:
    from recon.voxelmap.table import MAX_INDEX

    spacing, counts = np.array(image.spacing), np.asarray(image.cell_data["counts"])
    if not ((spacing == spacing[0]).all() and 0 < spacing[0] < np.inf):
        raise InputError(f"its cells have sides {spacing.tolist()}, but cubes are needed")
    if not (np.abs(image.origin) < float(spacing[0]) * MAX_INDEX).all():
        raise InputError(f"its origin {list(image.origin)} is out of reach")
    num_cells = int(np.prod(np.array(image.dimensions) - 1))
    is_whole = counts.shape == (num_cells,) and counts.dtype.kind in "iu"
    if not (is_whole and (counts >= 0).all()):
        raise InputError("its counts cannot come from points")


def _check_whole(path: Path) -> None:
    """Check for completeness: VTK itself would only print a message and continue."""
    content = path.read_bytes()
    extent = _EXTENT.search(content[:_HEADER_BYTES])
    if extent is None or not content.rstrip().endswith(b"</VTKFile>"):
        raise InputError("not a whole VTK image")
    ends = [int(word) for word in extent.groups()]
    num_cells = math.prod(high - low for low, high in zip(ends[::2], ends[1::2], strict=True))
    if num_cells > MAX_CELLS:
        raise InputError(f"claims {num_cells} cells, but at most {MAX_CELLS} are allowed")


def of_image(image: Any) -> Voxels:
    """The cells with points of a `pyvista.ImageData` created by `as_image`."""
    from recon.voxelmap.table import order_of

    cell_size = float(image.spacing[0])
    low = np.rint(np.array(image.origin) / cell_size).astype(np.int64)
    place = np.flatnonzero(image.cell_data["counts"])
    shape = np.array(image.dimensions) - 1
    index = low + np.column_stack(np.unravel_index(place, shape, order="F"))
    placed = {"index", "centres", "cell_size"}
    known = [name for name in Voxels.__slots__ if name in image.cell_data and name not in placed]
    fields = {name: np.asarray(image.cell_data[name])[place] for name in known}
    voxels = Voxels(
        index=index,
        centres=cell_centres(index, cell_size),
        cell_size=cell_size,
        **fields,
    )
    return voxels.select(order_of(index))


FORMAT = Format(write=write, read=read, takes=(Voxels,))
