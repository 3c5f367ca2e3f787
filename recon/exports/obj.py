"""The vertices and faces of an OBJ file (Wavefront), with the colours that stand behind places."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import RGB, XYZ, Columns
from recon.exports.format import Format, table
from recon.exports.meshes import write_mesh
from recon.exports.numbers import parsed
from recon.exports.triangles import Faces, check_faces, mesh_of
from recon.files import check_memory
from recon.records import Mesh

_COPIES = 10.0
_WITH_COLOUR = len(XYZ) + len(RGB)


@dataclass(slots=True)
class _Lines:
    """The lines of a file that hold places or faces."""

    places: list[bytes] = field(default_factory=list)
    faces: list[NDArray[np.int64]] = field(default_factory=list)


def read(path: Path) -> Columns:
    """The vertices in their order.

    Raises
    ------
    InputError
        Where a line is cut short, or a face names a vertex that is not there.
    """
    return _read(path)[0]


def read_mesh(path: Path) -> Mesh:
    """The vertices, and the faces cut into triangles."""
    return mesh_of(*_read(path))


def _read(path: Path) -> tuple[Columns, Faces]:
    check_memory(path, _COPIES * path.stat().st_size)
    lines = _Lines()
    for line in path.read_bytes().replace(b"\\\n", b" ").splitlines():
        words = line.split()
        if words and words[0] == b"v":
            lines.places.append(line.partition(b"v")[2])
        elif words and words[0] == b"f":
            lines.faces.append(_face(words[1:], len(lines.places)))
    if not lines.places:
        raise InputError("not an OBJ file (it holds no vertices)")
    check_faces(lines.faces, len(lines.places))
    return _columns(parsed(lines.places, None)), lines.faces


def _face(words: Sequence[bytes], num_vertices: int) -> NDArray[np.int64]:
    """Rows of vertices from 0 on; a negative number counts back from the last."""
    try:
        numbers = np.array([int(word.split(b"/")[0]) for word in words], np.int64)
    except (ValueError, OverflowError):
        raise InputError(f"a face is {b' '.join(words)[:40].decode('latin-1')!r}") from None
    if (numbers == 0).any():
        raise InputError("a face names vertex 0, but numbers begin at 1")
    return np.where(numbers < 0, numbers + num_vertices, numbers - 1)


def _columns(values: NDArray[np.float64]) -> Columns:
    """Places, and colours where three more numbers follow; a weight is passed over."""
    if values.shape[1] < len(XYZ):
        raise InputError(f"a vertex has {values.shape[1]} numbers, but x, y and z are needed")
    names = XYZ + (RGB if values.shape[1] >= _WITH_COLOUR else ())
    return dict(zip(names, values.T, strict=False))


def _has_faces(path: Path) -> bool:
    with path.open("rb") as file:
        return any(line.startswith((b"f ", b"f\t")) for line in file)


FORMAT: Format = table(read, None, mesh=(read_mesh, write_mesh, _has_faces))
