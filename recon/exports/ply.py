"""Points as PLY (Turk 1994): every value as a named vertex property."""

import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import NORMAL, RGB, XYZ, Columns, cloud_in, columns_of
from recon.exports.format import Format, table
from recon.exports.names import as_words
from recon.exports.numbers import held_columns
from recon.exports.plyheader import HELD, Element, Header, header, read_header
from recon.exports.plyrows import Rows, read_rows
from recon.exports.triangles import Faces, check_faces, mesh_of
from recon.files import atomic_path, check_memory
from recon.records import Mesh, MeshPart, PointCloud

RUN_CLOUD = np.dtype(
    [(name, "<f8") for name in XYZ]
    + [(name, "u1") for name in RGB]
    + [("sigma", "<f8"), ("pair", "<i4")]
)
"""Type of a vertex of the run folder's `cloud.ply`."""

_CHUNK_ROWS = 1 << 17


class CloudWriter:
    """Writes `cloud.ply` chunk by chunk; the file appears when the block ends without error.

    Example
    -------
    >>> with CloudWriter("cloud.ply") as writer:  # doctest: +SKIP
    ...     writer.append(cloud, pair_number=0)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = path
        self._count = 0
        self._stack = ExitStack()
        self._file: BinaryIO

    def __enter__(self) -> Self:
        temporary = self._stack.enter_context(atomic_path(self._path))
        self._file = self._stack.enter_context(temporary.open("wb"))
        self._file.write(header(RUN_CLOUD, 0))
        return self

    def append(self, cloud: PointCloud, pair_number: int | NDArray[np.integer]) -> None:
        """Add world points with the number of their pair; an unknown sigma becomes NaN."""
        columns = dict(zip(RGB, cloud.shown_colours.T, strict=True)) | columns_of(cloud)
        columns.setdefault("sigma", np.full(len(cloud), np.nan))
        vertices = as_vertices(
            columns | {"pair": np.broadcast_to(pair_number, len(cloud))}, RUN_CLOUD
        )
        self._file.write(vertices.tobytes())
        self._count += len(vertices)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.seek(0)
        self._file.write(header(RUN_CLOUD, self._count))
        self._stack.__exit__(kind, error, trace)


def read_cloud_chunks(
    path: str | os.PathLike[str],
) -> Iterator[tuple[PointCloud, NDArray[np.int32]]]:
    """The points of a run folder's cloud in chunks, with their pair numbers (M,)."""
    with Path(path).open("rb") as file:
        vertex = _run_vertices(read_header(file, path), path)
        _check_held(file, vertex, path)
        for start in range(0, vertex.count, _CHUNK_ROWS):
            vertices = np.fromfile(file, RUN_CLOUD, min(_CHUNK_ROWS, vertex.count - start))
            columns = {name: vertices[name] for name in RUN_CLOUD.names or ()}
            pair_number = columns.pop("pair")
            yield cloud_in(columns), pair_number


def _run_vertices(found: Header, path: str | os.PathLike[str]) -> Element:
    vertex = found.elements[0]
    if found.is_text or vertex.has_lists or vertex.row_dtype != RUN_CLOUD:
        names = ", ".join(one.name for one in vertex.properties)
        raise InputError(f"{path}: has {names}, which are not the properties of a run's cloud")
    return vertex


def _check_held(file: BinaryIO, vertex: Element, path: str | os.PathLike[str]) -> None:
    held = os.fstat(file.fileno()).st_size - file.tell()
    if held < vertex.count * vertex.min_row_bytes:
        raise InputError(f"{path}: {vertex.count} vertices are claimed, but {held} bytes follow")


def write(path: Path, columns: Columns) -> None:
    """Write columns as vertex properties, in the smallest PLY type that can hold them."""
    _write(path, columns, None)


def write_parts(path: Path, parts: Iterator[Columns], num: int) -> None:
    """Write columns in chunks, with `num` rows in total."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        for number, columns in enumerate(parts):
            held = held_columns(as_words(columns, path), HELD, path)
            dtype = _vertex_dtype(held)
            if number == 0:
                file.write(header(dtype, num))
            file.write(as_vertices(held, dtype).tobytes())


def _vertex_dtype(columns: Columns) -> np.dtype[np.void]:
    return np.dtype([(name, values.dtype.newbyteorder("<")) for name, values in columns.items()])


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write vertices, with colours and normals if there are any, and triangles."""
    columns = _columns_of(mesh)
    columns |= {name: v for name, v in mesh.attributes.items() if name not in columns}
    _write(path, columns, mesh.triangles)


def write_mesh_parts(path: Path, parts: Iterable[MeshPart], num: tuple[int, int]) -> None:
    """Write a mesh in parts, which are read twice, with `num` vertices and triangles in total."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        for number, part in enumerate(parts):
            held = held_columns(_columns_of(part), HELD, path)
            dtype = _vertex_dtype(held)
            if number == 0:
                file.write(header(dtype, *num))
            file.write(as_vertices(held, dtype).tobytes())
        for part in parts:
            file.write(_as_faces(part.triangles).tobytes())


def _columns_of(mesh: Mesh | MeshPart) -> Columns:
    columns: Columns = dict(zip(XYZ, mesh.vertices.T, strict=True))
    if mesh.normals is not None:
        columns |= zip(NORMAL, mesh.normals.T, strict=True)
    if mesh.colours is not None:
        columns |= zip(RGB, mesh.colours.T, strict=True)
    return columns


def _write(path: Path, columns: Columns, triangles: NDArray[np.integer] | None) -> None:
    """Write in chunks, since rows of one type would double the memory."""
    held = held_columns(as_words(columns, path), HELD, path)
    dtype = _vertex_dtype(held)
    num_faces = None if triangles is None else len(triangles)
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(header(dtype, len(columns["x"]), num_faces))
        for some in _chunks(len(columns["x"])):
            rows = {name: values[some] for name, values in held.items()}
            file.write(as_vertices(rows, dtype).tobytes())
        for some in _chunks(num_faces or 0):
            assert triangles is not None
            file.write(_as_faces(triangles[some]).tobytes())


def _chunks(num_rows: int) -> Iterator[slice]:
    return (slice(first, first + _CHUNK_ROWS) for first in range(0, num_rows, _CHUNK_ROWS))


def _as_faces(triangles: NDArray[np.integer]) -> NDArray[np.void]:
    faces = np.empty(len(triangles), [("length", "u1"), ("triangle", "<i4", 3)])
    faces["length"], faces["triangle"] = 3, triangles
    return faces


def read(path: Path) -> Columns:
    """The properties of the vertices of a binary or text file from any program.

    Raises
    ------
    InputError
        If the file is not a PLY file of vertices, has less data than it claims, or its faces refer
        to missing vertices.
    """
    rows = _rows(path, {"vertex", "face"})
    check_faces(_faces(rows.get("face")), rows["vertex"].count)
    return rows["vertex"].columns


def read_mesh(path: Path) -> Mesh:
    """The vertices, and the faces split into triangles.

    Raises
    ------
    InputError
        If it has no faces, or one that refers to a missing vertex.
    """
    rows = _rows(path, {"vertex", "face"})
    return mesh_of(rows["vertex"].columns, _faces(rows.get("face")))


def has_faces(path: Path) -> bool:
    """True if a file contains faces, too."""
    with path.open("rb") as file:
        face = read_header(file, path).element("face")
    return face is not None and face.count > 0


def _faces(rows: Rows | None) -> Faces:
    lists = rows.lists if rows else {}
    names = [name for name in ("vertex_indices", "vertex_index") if name in lists]
    return lists[names[0]] if names else []


def _rows(path: Path, names: set[str]) -> dict[str, Rows]:
    with path.open("rb") as file:
        found = read_header(file, path)
        _check_memory(found, path)
        content = file.read()
    return read_rows(content, found, names)


def _check_memory(found: Header, path: Path) -> None:
    # Text is measured by its size, which exceeds that of its numbers.
    size = path.stat().st_size
    claimed = sum(one.count * one.min_row_bytes for one in found.elements)
    check_memory(path, 3 * max(size, claimed if not found.is_text else 0))


def as_vertices(columns: Columns, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Columns as rows of one structured type."""
    vertices = np.empty(len(columns["x"]), dtype)
    for name in dtype.names or ():
        vertices[name] = columns[name]
    return vertices


FORMAT: Format = table(
    read, write, mesh=(read_mesh, write_mesh, has_faces), write_parts=write_parts
)
