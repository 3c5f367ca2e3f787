"""All formats by suffix: one table, one function to write and one to read."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from recon.errors import InputError, check_number
from recon.exports.content import Box, inside, is_in_partitions, is_map
from recon.exports.format import Data, Format, Up
from recon.exports.partitions.store import is_partitioned
from recon.exports.triangles import sampled
from recon.exports.turning import R_YUP_ZUP, R_ZUP_YUP, turned
from recon.files import PathLike, check_name, check_regular
from recon.notices import notify
from recon.plugins import Registry
from recon.records import Mesh, PointCloud, Voxels

if TYPE_CHECKING:  # maps bring their kernels, which tables of points do without
    from recon.exports.partitions.partitioned import PartitionedMap
    from recon.voxelmap import VoxelMap

_HOMES = {
    ".ply": "ply", ".pcd": "pcd", ".las": "las", ".laz": "las", ".parquet": "parquet",
    ".zarr": "zarr", ".npz": "npz", ".npy": "npz:NPY", ".vti": "vti", ".bt": "octomap",
    ".ot": "octomap", ".glb": "glb", ".pgm": "nav2", ".yaml": "nav2", ".yml": "nav2",
    ".xyz": "text", ".txt": "text", ".csv": "text", ".pts": "text:PTS", ".asc": "text",
    ".e57": "e57", ".obj": "obj", ".stl": "meshes", ".off": "meshes", ".vtk": "vtk",
    ".vtp": "vtk", ".vtu": "vtk",
}  # fmt: skip


def _home(place: str) -> str:
    module, _, name = place.partition(":")
    return f"recon.exports.{module}:{name or 'FORMAT'}"


FORMATS: Registry[Format] = Registry(
    "recon.formats", "format", {ending: _home(place) for ending, place in _HOMES.items()}
)
"""Formats by suffix, including those of installed packages."""


def format_of(path: PathLike) -> Format:
    """The format of a file, by its suffix.

    Raises
    ------
    InputError
        For an unknown suffix.
    """
    ending = Path(path).suffix.lower()
    if ending == ".gz":
        raise InputError(f"{path} is compressed, but recon reads plain files: unpack it (gunzip)")
    if ending not in FORMATS:
        known = " ".join(FORMATS.names())
        raise InputError(f"{path}: the ending {ending!r} is unknown; known are {known}")
    return FORMATS.load(ending)


def write(
    data: "Data | PartitionedMap", path: PathLike, box: Box | None = None, *, up: Up | None = None
) -> None:
    """Write a cloud, cells, a map or a mesh atomically, in the format of the suffix of `path`.

    Formats of robotics and surveying (.las .laz .bt .ot .pgm) have z up; data is rotated when
    written: (x, y, z) becomes (x, -z, y).

    Parameters
    ----------
    data : PointCloud, Voxels, VoxelMap, PartitionedMap or Mesh
        For a map, all cells with a point; a partitioned one is written in chunks if the format
        allows (.ply .parquet .csv .xyz .txt .asc), else as a whole.
    path : path
    box : (low, high), optional
        Write only points, or cells with their centre, between these corners (3,), world.
    up : "y" or "z", optional
        The axis that is up in the file; by default the format's own.

    Raises
    ------
    InputError
        For an unknown suffix, or data that the format cannot store.
    MissingLibraryError
        If the library of the format is not installed.
    """
    check_name(path)
    form = format_of(path)
    if up not in (None, "y", "z"):
        raise InputError(f"up is {up!r}, but y or z is needed")
    if box is not None:
        data = inside(data, box, path)
    if is_in_partitions(data):
        if form.write_parts and up in (None, form.up) and data.num_cells > 0:
            form.write_parts(Path(path), (one.occupied(1) for one in data), data.num_cells)
            return
        data = data.whole()
    if up is not None and up != form.up:
        # The format rotates it once more by the same angle.
        data = turned(_cells_of(data), R_ZUP_YUP if up == "z" else R_YUP_ZUP)
    _write_whole(data, path, form)


def write_parts(parts: Iterable[PointCloud], num: int, path: PathLike) -> None:
    """Write the points of one or more parts, `num` in total, one part in memory at a time.

    Raises
    ------
    InputError
        For an unknown suffix, or a format that needs all points at once.
    """
    form = format_of(path)
    if form.write_parts is None:
        raise InputError(f"{path}: the format needs all points at once")
    form.write_parts(Path(path), iter(parts), num)


def _write_whole(data: Data, path: PathLike, form: Format) -> None:
    if isinstance(data, Mesh):
        if form.write_mesh is None:
            raise InputError(f"{path}: the format cannot hold triangles; give --sample N")
        form.write_mesh(Path(path), data)
        return
    if is_map(data) and not isinstance(data, form.takes):
        data = data.occupied(min_count=1)
    if form.write is None or not isinstance(data, form.takes):
        raise InputError(f"{path}: {_cannot_hold(form, data)}")
    form.write(Path(path), data)


def _cannot_hold(form: Format, data: Data) -> str:
    if form.write is None and form.write_mesh is None:
        return "the format is read-only"
    if not is_map(data) and not isinstance(data, PointCloud | Voxels):
        return f"data is a {type(data).__name__}, but a cloud, cells, a map or a mesh is needed"
    kind = "a cloud of points" if isinstance(data, PointCloud) else "cells"
    holds = "triangles" if form.write is None else "cells"
    return f"a format for {holds} cannot hold {kind}"


def read(
    path: PathLike,
    *,
    columns: Sequence[str] | None = None,
    sample: int | None = None,
    seed: int = 0,
) -> "PointCloud | Voxels | VoxelMap | PartitionedMap":
    """Read a cloud, cells or a map, with y up, in the format of the suffix of `path`.

    Parameters
    ----------
    path : path
        A file, or the folder or URL of a partitioned map, which is read on demand.
    columns : sequence of str, optional
        Names of the columns of a table of text.
    sample : int, optional
        Number of points sampled from a cloud, or evenly from the triangles of a mesh, whose
        vertices are taken by default.
    seed : int
        Of the sample.

    Raises
    ------
    InputError
        For an unknown suffix, one without clouds or maps, or a damaged file.
    MissingLibraryError
        If the library of the format is not installed.
    """
    data = read_silently(path, columns=columns, sample=sample, seed=seed)
    if format_of(path).up == "z":
        notify("turned-to-y-up", f"{path} has z up: (x, y, z) was read as (x, z, -y)")
    return data


def read_silently(
    path: PathLike,
    *,
    columns: Sequence[str] | None = None,
    sample: int | None = None,
    seed: int = 0,
) -> "PointCloud | Voxels | VoxelMap | PartitionedMap":
    """Do the same as `read`, without a notice about the rotation."""
    check_name(path)
    if sample is not None:
        check_number("sample", sample, low=0)
    rng = np.random.default_rng(seed)
    if is_partitioned(path):
        from recon.exports.partitions.partitioned import PartitionedMap

        found = PartitionedMap(path)
        return found if sample is None else _drawn(found.whole(), sample, rng)
    form = _readable(path)
    if sample is not None and holds_mesh(path):
        return sampled(read_mesh(path), sample, rng)
    assert form.read is not None
    given: dict[str, Any] = {"columns": columns} if columns else {}
    if not given.keys() <= form.options:
        raise InputError(f"{path}: names its columns itself, but --columns are given")
    data = _named(path, form.read, **given)
    return data if sample is None else _drawn(data, sample, rng)


def _readable(path: PathLike) -> Format:
    if not Path(path).exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    if Path(path).suffix.lower() != ".zarr":
        check_regular(path)
    form = format_of(path)
    if form.read is None:
        raise InputError(f"{path}: holds neither a cloud nor a map that can be read back")
    return form


def _named(path: PathLike, reader: Any, **given: Any) -> Any:
    """Call a reader; its errors name the file."""
    try:
        return reader(Path(path), **given)
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {error}") from error


def _drawn(
    data: "PointCloud | Voxels | VoxelMap", num: int, rng: np.random.Generator
) -> PointCloud | Voxels:
    """Some points or cells, in their original order."""
    rows = data.occupied(min_count=1) if is_map(data) else data
    if num >= len(rows):
        return rows
    return rows.select(np.sort(rng.choice(len(rows), num, replace=False)))


def holds_mesh(path: PathLike) -> bool:
    """True if a file contains triangles."""
    if is_partitioned(path):
        return False
    form = _readable(path)
    return form.read_mesh is not None and bool(_named(path, form.has_mesh))


def read_mesh(path: PathLike) -> Mesh:
    """Read triangles, with y up, in the format of the suffix of `path`.

    Raises
    ------
    InputError
        For a suffix or a file without triangles, or a damaged file.
    """
    form = _readable(path)
    if form.read_mesh is None:
        raise InputError(f"{path}: the format cannot hold triangles")
    mesh: Mesh = _named(path, form.read_mesh)
    return mesh


def _cells_of(data: Data) -> PointCloud | Voxels | Mesh:
    return data.occupied(min_count=1) if is_map(data) else data
