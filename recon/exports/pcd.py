"""Points as PCD (Point Cloud Library), by Open3D: every value a named field."""

from pathlib import Path

from recon.errors import InputError, ReconError
from recon.exports.columns import XYZ, Columns
from recon.exports.open3d import cloud_of, columns_in
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
    cloud = cloud_of(columns)
    with atomic_path(path) as temporary:
        if not load_open3d().t.io.write_point_cloud(str(temporary), cloud):
            raise ReconError(f"{path}: Open3D could not write it")


def read(path: Path) -> Columns:
    """The fields of the points.

    Raises
    ------
    InputError
        Where Open3D finds none.
    """
    o3d = load_open3d()
    try:
        # What is wrong Open3D would say on the screen, and go on with an empty cloud.
        with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
            columns = columns_in(o3d.t.io.read_point_cloud(str(path)))
    except RuntimeError as error:
        raise InputError(f"{path}: Open3D cannot read it") from error
    if not set(XYZ) <= columns.keys():
        raise InputError(f"{path}: Open3D finds no points in it")
    return columns
