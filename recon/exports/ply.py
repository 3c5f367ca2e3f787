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
from recon.files import atomic_path
from recon.records import PointCloud

# As numpy reads them, little-endian; both generations of names.
_TYPES = {
    "char": "<i1", "uchar": "<u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4",
    "float": "<f4", "double": "<f8",
    "int8": "<i1", "uint8": "<u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4",
    "uint32": "<u4", "float32": "<f4", "float64": "<f8",
}  # fmt: skip
_NAMES = {"<i1": "char", "|i1": "char", "|u1": "uchar", "<i2": "short", "<u2": "ushort",
          "<i4": "int", "<u4": "uint", "<f4": "float", "<f8": "double"}  # fmt: skip

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
        vertices = np.empty(len(cloud), RUN_CLOUD)
        for axis, name in enumerate("xyz"):
            vertices[name] = cloud.points[:, axis]
        for channel, name in enumerate(("red", "green", "blue")):
            vertices[name] = cloud.colours[:, channel]
        vertices["sigma"] = np.nan if cloud.sigma is None else cloud.sigma
        vertices["pair"] = pair_number
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
        dtype, count = read_header(file, path)
        if dtype != RUN_CLOUD:
            raise InputError(
                f"{path}: its properties are {dtype.names}, not those of a run's cloud"
            )
        for start in range(0, count, _CHUNK_ROWS):
            vertices = np.fromfile(file, dtype, min(_CHUNK_ROWS, count - start))
            yield as_cloud(vertices), vertices["pair"]


def as_cloud(vertices: NDArray[np.void]) -> PointCloud:
    """The points of vertices that have x, y, z, red, green, blue and sigma."""
    return PointCloud(
        points=np.column_stack([vertices[name] for name in "xyz"]),
        colours=np.column_stack([vertices[name] for name in ("red", "green", "blue")]),
        sigma=vertices["sigma"].astype(np.float64),
    )


def header(dtype: np.dtype[np.void], count: int) -> bytes:
    """The header of binary vertices; as long for every count, so that it can be written again."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count:012d}"]
    lines += [f"property {_NAMES[dtype[name].str]} {name}" for name in dtype.names or ()]
    return "\n".join([*lines, "end_header", ""]).encode("ascii")


def read_header(file: BinaryIO, path: str | os.PathLike[str]) -> tuple[np.dtype[np.void], int]:
    """The type and number of the vertices that follow.

    Raises
    ------
    InputError
        Where the file is no binary PLY of plain vertices, or holds less than it claims.
    """
    lines: list[str] = []
    while not lines or lines[-1] != "end_header":
        line = file.readline(200)
        if not line:
            raise InputError(f"{path}: not a PLY file with a whole header")
        lines.append(line.decode("ascii", "replace").strip())
    fields = [
        (words[2], _TYPES[words[1]]) for words in map(str.split, lines) if words[:1] == ["property"]
    ]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    dtype = np.dtype(fields)
    held = os.fstat(file.fileno()).st_size - file.tell()
    if held < count * dtype.itemsize:
        raise InputError(f"{path}: {count} vertices are claimed, but {held} bytes follow")
    return dtype, count
