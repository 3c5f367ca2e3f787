"""The record of one file format, and formats that are tables of points."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from recon.exports.columns import Columns, columns_of, from_columns
from recon.exports.numbers import drop_columns
from recon.exports.turning import R_YUP_ZUP, R_ZUP_YUP, turned
from recon.records import Crs, Mesh, PointCloud, Voxels

if TYPE_CHECKING:  # maps bring their kernels, which tables of points do without
    from recon.voxelmap import VoxelMap

Data: TypeAlias = "PointCloud | Voxels | VoxelMap | Mesh"
Up = Literal["y", "z"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """Reading and writing of files of one suffix; data in memory has y up."""

    read: "Callable[..., PointCloud | Voxels | VoxelMap] | None" = None
    """Path, and the `options` by name. None if it contains neither a map nor a cloud."""
    write: Callable[[Path, Any], None] | None = None
    """None if the format is read-only."""
    up: Up = "y"
    """The axis that is up in the file."""
    takes: tuple[type, ...] = (PointCloud, Voxels)
    """Types that can be written; a map that is not among these is written as cells."""
    options: frozenset[str] = frozenset()
    """Keywords that `read` accepts."""
    read_mesh: Callable[[Path], Mesh] | None = None
    write_mesh: Callable[[Path, Mesh], None] | None = None
    has_mesh: Callable[[Path], bool] = lambda _: True
    """True if a file contains triangles, in a format that supports them."""
    write_parts: "Callable[[Path, Iterator[PointCloud | Voxels], int], None] | None" = None
    """Writes points or cells in chunks, given their total number; None if it needs all at once."""


MeshAccess = tuple[
    Callable[[Path], Mesh], Callable[[Path, Mesh], None] | None, Callable[[Path], bool]
]
"""Reads triangles, writes them, and tells if a file has some."""


def table(
    read: Callable[..., Columns | tuple[Columns, Crs | None]],
    write: Callable[..., None] | None,
    *,
    up: Up = "y",
    options: frozenset[str] = frozenset(),
    keeps_crs: bool = False,
    mesh: MeshAccess | tuple[None, None, Any] = (None, None, lambda _: False),
    write_parts: Callable[[Path, Iterator[Columns], int], None] | None = None,
) -> Format:
    """A format of named columns.

    Parameters
    ----------
    read, write : callables
        Columns of a path, with the coordinate reference system if `keeps_crs`.
    write_parts : callable, optional
        Writes columns in chunks, given their total number of rows; for formats with y up.
    """

    def read_table(path: Path, **given: Any) -> PointCloud | Voxels:
        found = read(path, **given)
        columns, crs = found if isinstance(found, tuple) else (found, None)
        data = from_columns(columns, crs)
        return data if up == "y" else turned(data, R_YUP_ZUP)

    def write_table(path: Path, data: PointCloud | Voxels) -> None:
        assert write is not None
        columns = columns_of(data if up == "y" else turned(data, R_ZUP_YUP))
        crs = data.crs if isinstance(data, PointCloud) else None
        if keeps_crs:
            write(path, columns, crs)
            return
        if crs is not None:
            drop_columns(["the coordinate reference system"], path)
        write(path, columns)

    def write_chunks(path: Path, parts: Iterator[PointCloud | Voxels], num: int) -> None:
        assert write_parts is not None
        write_parts(path, map(columns_of, parts), num)

    return Format(
        read=read_table,
        write_parts=None if write_parts is None else write_chunks,
        write=None if write is None else write_table,
        up=up,
        options=options,
        read_mesh=mesh[0],
        write_mesh=mesh[1],
        has_mesh=mesh[2],
    )
