"""Points as PLY (Turk 1994): every value a named property of a vertex."""

import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import Columns, cloud_in, columns_of
from recon.exports.plyheader import Layout, header, read_header
from recon.files import atomic_path
from recon.records import PointCloud

RUN_CLOUD = np.dtype(
    [(name, "<f8") for name in "xyz"]
    + [(name, "u1") for name in ("red", "green", "blue")]
    + [("sigma", "<f8"), ("pair", "<i4")]
)
"""A vertex of the run folder's `cloud.ply`."""

_CHUNK_ROWS = 1 << 17


class CloudWriter:
    """Writes `cloud.ply` chunk by chunk; it appears whole when the block ends well.

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

    def append(self, cloud: PointCloud, pair_number: int) -> None:
        """Add the world points of one pair; a sigma that is not known becomes NaN."""
        columns = columns_of(cloud)
        columns.setdefault("sigma", np.full(len(cloud), np.nan))
        vertices = as_vertices(columns | {"pair": np.full(len(cloud), pair_number)}, RUN_CLOUD)
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
    """The points of a run folder's cloud in pieces, each with the number of its pair (M,)."""
    with Path(path).open("rb") as file:
        layout = read_header(file, path)
        if layout.dtype != RUN_CLOUD:
            raise InputError(f"{path}: holds {layout.dtype.names}, not what a run's cloud holds")
        for start in range(0, layout.count, _CHUNK_ROWS):
            vertices = np.fromfile(file, RUN_CLOUD, min(_CHUNK_ROWS, layout.count - start))
            cloud = cloud_in({name: vertices[name] for name in RUN_CLOUD.names or ()})
            yield cloud, vertices["pair"]


def write(path: Path, columns: Columns) -> None:
    """Write columns as the properties of vertices, in the smallest type of PLY that holds them."""
    dtype = np.dtype([(name, values.dtype) for name, values in columns.items()])
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(header(dtype, len(columns["x"])))
        file.write(as_vertices(columns, dtype).tobytes())


def read(path: Path) -> Columns:
    """The properties of the vertices, of a binary or a text file, whoever wrote it.

    Raises
    ------
    InputError
        Where the file is no PLY of plain vertices, or holds less than it claims.
    """
    with path.open("rb") as file:
        layout = read_header(file, path)
        if layout.is_text:
            vertices = _read_text(file, layout, path)
        else:
            vertices = np.fromfile(file, layout.dtype, layout.count)
    return {name: vertices[name] for name in layout.dtype.names or ()}


def _read_text(file: BinaryIO, layout: Layout, path: Path) -> NDArray[np.void]:
    if not layout.count:
        return np.empty(0, layout.dtype)
    try:
        rows = np.loadtxt(file, layout.dtype, max_rows=layout.count, ndmin=1)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    if len(rows) != layout.count:
        raise InputError(f"{path}: {layout.count} vertices are claimed, but {len(rows)} follow")
    return rows


def as_vertices(columns: Columns, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Columns as rows of one structured type."""
    vertices = np.empty(len(columns["x"]), dtype)
    for name in dtype.names or ():
        vertices[name] = columns[name]
    return vertices
