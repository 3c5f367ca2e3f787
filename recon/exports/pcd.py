"""Points as PCD (Point Cloud Library), by Open3D: every value a named field."""

from pathlib import Path

import numpy as np

from recon.errors import InputError, ReconError
from recon.exports.columns import RGB, XYZ, Columns
from recon.files import atomic_path
from recon.libraries import load_open3d


def write(path: Path, columns: Columns) -> None:
    """Write columns as fields.

    Raises
    ------
    InputError
        Where there is nothing to write.
    ReconError
        Where Open3D says, without an error of its own, that it did not write.
    """
    if not len(columns["x"]):
        raise InputError(f"{path}: there are no points, but Open3D writes no empty PCD")
    o3d = load_open3d()
    cloud = o3d.t.geometry.PointCloud()
    for field, names in (("positions", XYZ), ("colors", RGB)):
        cloud.point[field] = o3d.core.Tensor(np.column_stack([columns[n] for n in names]))
    for name, values in columns.items():
        if name not in XYZ + RGB:
            cloud.point[name] = o3d.core.Tensor(np.ascontiguousarray(values)[:, None])
    with atomic_path(path) as temporary:
        if not o3d.t.io.write_point_cloud(str(temporary), cloud):
            raise ReconError(f"{path}: Open3D could not write it")


def read(path: Path) -> Columns:
    """The fields of the points."""
    o3d = load_open3d()
    try:
        # What is wrong Open3D would say on the screen, and go on with an empty cloud.
        with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
            cloud = o3d.t.io.read_point_cloud(str(path))
    except RuntimeError as error:
        raise InputError(f"{path}: Open3D cannot read it") from error
    if "positions" not in cloud.point:
        raise InputError(f"{path}: Open3D finds no points in it")
    columns: Columns = dict(zip(XYZ, cloud.point["positions"].numpy().T, strict=True))
    if "colors" in cloud.point:
        columns |= zip(RGB, cloud.point["colors"].numpy().T, strict=True)
    for name, values in cloud.point.items():
        if name not in ("positions", "colors") and values.shape[1] == 1:
            columns[name] = values.numpy()[:, 0]
    # Clouds of depth cameras mark with NaN where nothing was measured.
    is_measured = np.isfinite([columns[name] for name in XYZ]).all(axis=0)
    return {name: values[is_measured] for name, values in columns.items()}
