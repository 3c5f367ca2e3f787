"""The vertices and faces of an OBJ file (Wavefront), with vertex or material colours."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import RGB, XYZ, Columns
from recon.exports.format import Format, table
from recon.exports.materials import material_names, painted, read_colours, write_materials
from recon.exports.numbers import drop_columns, parsed
from recon.exports.triangles import Faces, check_faces, mesh_of
from recon.files import atomic_path, check_memory
from recon.records import Mesh

_COPIES = 10.0
_WITH_COLOUR = len(XYZ) + len(RGB)


@dataclass(slots=True)
class _Lines:
    """The lines of a file with vertices or faces."""

    places: list[bytes] = field(default_factory=list)
    faces: list[NDArray[np.int64]] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    materials: list[str | None] = field(default_factory=list)
    """Material of every face."""


def read(path: Path) -> Columns:
    """The vertices in their order.

    Raises
    ------
    InputError
        If a line is truncated, or a face refers to a missing vertex.
    """
    return _read(path)[0]


def read_mesh(path: Path) -> Mesh:
    """The vertices, and the faces cut into triangles."""
    return mesh_of(*_read(path))


def _read(path: Path) -> tuple[Columns, Faces]:
    check_memory(path, _COPIES * path.stat().st_size)
    lines = _lines(path.read_bytes().replace(b"\r\n", b"\n").replace(b"\\\n", b" "))
    if not lines.places:
        raise InputError("not an OBJ file (it holds no vertices)")
    check_faces(lines.faces, len(lines.places))
    columns = _columns(parsed(lines.places, None))
    return (columns if "red" in columns else columns | _painted(path, lines)), lines.faces


def _lines(content: bytes) -> _Lines:
    lines = _Lines()
    material = None
    for line in content.splitlines():
        key, _, rest = line.strip().replace(b"\t", b" ").partition(b" ")
        if key == b"v":
            lines.places.append(rest)
        elif key == b"f":
            lines.faces.append(_face(rest.split(), len(lines.places)))
            lines.materials.append(material)
        elif key == b"mtllib":
            lines.libraries.append(rest.strip().decode("utf-8", "replace"))
        elif key == b"usemtl":
            material = rest.strip().decode("utf-8", "replace")
    return lines


def _painted(path: Path, lines: _Lines) -> Columns:
    """Colours by material, if all vertices have one."""
    if not lines.libraries:
        return {}
    colours = read_colours(path, lines.libraries)
    values = painted(len(lines.places), lines.faces, lines.materials, colours)
    return {} if values is None else dict(zip(RGB, values.T, strict=True))


def _face(words: Sequence[bytes], num_vertices: int) -> NDArray[np.int64]:
    """Vertex indices, starting at 0; a negative number counts back from the last."""
    try:
        numbers = np.array([int(word.split(b"/")[0]) for word in words], np.int64)
    except (ValueError, OverflowError):
        raise InputError(f"a face is {b' '.join(words)[:40].decode('latin-1')!r}") from None
    if (numbers == 0).any():
        raise InputError("a face names vertex 0, but indices start at 1")
    return np.where(numbers < 0, numbers + num_vertices, numbers - 1)


def _columns(values: NDArray[np.float64]) -> Columns:
    """Coordinates, and colours if three more numbers follow; a weight is ignored."""
    if values.shape[1] < len(XYZ):
        raise InputError(f"a vertex has {values.shape[1]} numbers, but x, y and z are needed")
    names = XYZ + (RGB if values.shape[1] >= _WITH_COLOUR else ())
    return dict(zip(names, values.T, strict=False))


def _has_faces(path: Path) -> bool:
    with path.open("rb") as file:
        return any(line.startswith((b"f ", b"f\t")) for line in file)


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write vertices with their colours and triangles, and a .mtl of plain colours beside it.

    Some programs read the colours of vertices, others those of materials.
    """
    drop_columns([*mesh.attributes], path)
    rows = mesh.vertices
    names: list[str] = []
    if mesh.colours is not None:
        rows = np.column_stack([rows, mesh.colours / 255.0])
        names = material_names(mesh)
        write_materials(path.with_suffix(".mtl"), names)
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write(f"mtllib {path.with_suffix('.mtl').name}\n" if names else "")
        file.writelines(f"v {' '.join(map(repr, row))}\n" for row in rows.tolist())
        file.writelines(_triangle_lines(mesh, names))


def _triangle_lines(mesh: Mesh, names: Sequence[str]) -> Iterator[str]:
    """The triangles in their order, with a material line whenever it changes."""
    last = None
    for number, (a, b, c) in enumerate((mesh.triangles + 1).tolist()):
        if names and names[number] != last:
            last = names[number]
            yield f"usemtl {last}\n"
        yield f"f {a} {b} {c}\n"


FORMAT: Format = table(read, None, mesh=(read_mesh, write_mesh, _has_faces))
