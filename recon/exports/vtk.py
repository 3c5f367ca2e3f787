"""Points of VTK's other files (.vtk .vtp .vtu, and .vti of others), by pyvista."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.arrays import columns_in
from recon.exports.columns import RGB, XYZ, Columns, from_columns
from recon.exports.format import Format, table
from recon.exports.vtkheader import check_claims
from recon.libraries import load_pyvista, silent
from recon.notices import notify
from recon.records import PointCloud, Voxels


def read(path: Path) -> Columns:
    """The points, or cell centres if only cells have values, with every value by name.

    From a block (.vti, structured points) only positions with a value other than 0 are read.

    Raises
    ------
    InputError
        If the file is damaged or contains no points.
    """
    mesh = read_dataset(path)
    if not mesh.n_points:
        raise InputError("it holds no points")
    has_cells = not mesh.point_data.keys() and bool(mesh.cell_data.keys())
    points = mesh.cell_centers().points if has_cells else mesh.points
    values = mesh.cell_data if has_cells else mesh.point_data
    # Scalars may have no name, or one that is not text.
    names = [name for name in list(values.keys()) if name and isinstance(name, str)]
    arrays = {_name(name, values[name]): np.asarray(values[name]) for name in names}
    columns = columns_in({"points": np.asarray(points)} | arrays)
    return _with_value(columns, path) if load_pyvista().ImageData is type(mesh) else columns


def read_dataset(path: Path) -> Any:
    """The dataset of a file, without VTK's output.

    Raises
    ------
    InputError
        If VTK cannot read it.
    """
    check_claims(path.read_bytes(), path)
    pyvista = load_pyvista()
    try:
        with silent(), warnings.catch_warnings(action="error"):
            found = pyvista.read(path)
    # VTK and PyVista raise errors of any kind.
    except Exception as error:
        raise InputError("VTK cannot read it") from error
    if not isinstance(found, pyvista.DataSet):
        raise InputError(f"holds a {type(found).__name__}, but one dataset is needed")
    return found


def _name(name: str, values: Any) -> str:
    """The name of an array; colours get a common name."""
    is_colour = values.ndim == 2 and values.shape[1] in (3, 4) and values.dtype == np.uint8
    return "rgb" if is_colour and ("rgb" in name.lower() or "col" in name.lower()) else name


def _with_value(columns: Columns, path: Path) -> Columns:
    """The rows with a value that is neither 0 nor NaN; all if there are no values."""
    values = [v for name, v in columns.items() if name not in (*XYZ, *RGB)]
    if not values:
        return columns
    is_kept = np.any([np.nan_to_num(v) != 0 for v in values], axis=0)
    if not is_kept.all():
        notify(
            "places-left-out",
            f"{path}: {(~is_kept).sum()} of {len(is_kept)} positions of the block have the value 0 "
            "or none; they are left out",
        )
    return {name: column[is_kept] for name, column in columns.items()}


def read_points(path: Path) -> PointCloud | Voxels:
    """The points of a file as a cloud."""
    return from_columns(read(path))


FORMAT: Format = table(read, None)
