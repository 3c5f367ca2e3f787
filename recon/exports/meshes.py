"""Triangles as STL, OFF and GLB, by trimesh."""

import io
import logging
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError, one_line
from recon.exports.columns import measured
from recon.exports.format import Format
from recon.exports.numbers import drop_columns
from recon.files import atomic_path, check_memory
from recon.files.documents import parse_json
from recon.libraries import load_extra
from recon.notices import notify
from recon.records import Mesh, PointCloud

_STL_HEADER_BYTES, _STL_TRIANGLE_BYTES = 84, 50
_COPIES = 10.0

_MAX_DIGITS = 16
_GLUED_OFF = re.compile(rb"\A(C?N?OFF)(?=[ \t]*\d)")

_EXPORTS: dict[str, dict[str, Any]] = {"off": {"digits": 17}}


def read_mesh(path: Path) -> Mesh:
    """All triangles of a file, in one frame.

    Raises
    ------
    InputError
        If it is truncated or contains no triangles.
    """
    parts = [part for part in _parts(path) if len(getattr(part, "faces", ()))]
    if not parts:
        raise InputError("it holds no triangles, but a mesh is needed")
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return Mesh(
        vertices=_vertices(parts),
        triangles=np.concatenate(
            [part.faces + start for part, start in zip(parts, starts, strict=False)]
        ).astype(np.int32),
        colours=_colours(parts),
    )


def read(path: Path) -> PointCloud:
    """The vertices of a file, of triangles and of points."""
    parts = [part for part in _parts(path) if len(getattr(part, "vertices", ()))]
    if not parts:
        raise InputError("it holds no vertices")
    return measured(PointCloud(points=_vertices(parts), colours=_colours(parts)))


def _parts(path: Path) -> list[Any]:
    """The geometries of a file, each transformed to its position."""
    trimesh = load_extra("trimesh", "mesh")
    # trimesh logs errors with tracebacks before it raises.
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    # Files of ModelNet lack the first line's end.
    content = _GLUED_OFF.sub(rb"\1\n", path.read_bytes(), count=1)
    check_memory(path, _COPIES * len(content))
    ending = path.suffix.lower().removeprefix(".")
    if ending in _CHECKS:
        _CHECKS[ending](content)
    try:
        scene = trimesh.load_scene(
            io.BytesIO(content), file_type=ending, process=False, maintain_order=True,
            skip_materials=True,
        )  # fmt: skip
        parts = list(scene.dump())
        if ending == "stl":
            # Each triangle has its own corners, unconnected to its neighbours.
            for part in parts:
                part.merge_vertices()
        return parts
    # trimesh's readers raise errors of any kind.
    except Exception as error:
        raise InputError(f"not a whole {ending.upper()} file ({_reason(error)})") from error


def _check_stl(content: bytes) -> None:
    """Check that a binary file has its claimed size, and that a text has an end."""
    if content[:5].lower() == b"solid" and b"facet" in content[:2000].lower():
        if b"endsolid" not in content[-2000:].lower():
            raise InputError("not a whole STL file (its text has no end)")
        return
    count = int.from_bytes(content[80:84], "little")
    held = len(content) - _STL_HEADER_BYTES
    if held < 0:
        raise InputError(f"not a whole STL file (it has {len(content)} bytes and no facet)")
    if held < count * _STL_TRIANGLE_BYTES:
        raise InputError(f"{count} triangles are claimed, but {held} bytes follow")


def _check_glb(content: bytes) -> None:
    claimed = int.from_bytes(content[8:12], "little")
    if content[:4] != b"glTF" or claimed > len(content):
        raise InputError(f"not a whole GLB file ({claimed} bytes are claimed)")
    length = int.from_bytes(content[12:16], "little")
    tree = parse_json(content[20 : 20 + length].decode("utf-8", "replace"), "its JSON")
    packed = [name for name in _required(tree) if "draco" in name or "meshopt" in name]
    if packed:
        raise InputError(f"its triangles are compressed ({packed[0]}): decompress it first")


def _required(tree: object) -> list[str]:
    """Names of the extensions without which the content cannot be read."""
    names = tree.get("extensionsRequired", []) if isinstance(tree, dict) else []
    return [str(name) for name in names] if isinstance(names, list) else []


def _check_off(content: bytes) -> None:
    lines = [line.split(b"#")[0] for line in content.splitlines()]
    words = b" ".join(lines).split()
    if not words or words[0].upper() not in (b"OFF", b"COFF", b"NOFF", b"CNOFF"):
        raise InputError("not an OFF file (wrong first line)")
    if words[0].upper().startswith(b"C"):
        notify("colour-missing", "colours of an OFF file are not read; its vertices have none")
    counts = [int(word) for word in words[1:4] if word.isdigit() and len(word) < _MAX_DIGITS]
    if len(counts) < 2 or len(words) < 4 + 3 * counts[0] + 4 * counts[1]:
        raise InputError(f"not a whole OFF file ({counts[:2]} vertices and faces are claimed)")


_CHECKS: dict[str, Callable[[bytes], None]] = {
    "stl": _check_stl, "glb": _check_glb, "off": _check_off,
}  # fmt: skip


def _vertices(parts: list[Any]) -> NDArray[np.float64]:
    return np.concatenate([np.asarray(part.vertices, np.float64) for part in parts])


def _colours(parts: list[Any]) -> NDArray[np.uint8] | None:
    """RGB of the vertices, if all parts have vertex colours."""
    found = [_vertex_colours(part) for part in parts]
    kept = [colours for colours in found if colours is not None]
    return np.concatenate(kept) if len(kept) == len(found) else None


def _vertex_colours(part: Any) -> NDArray[np.uint8] | None:
    if getattr(part, "faces", None) is None:
        colours = np.asarray(part.colors)
    elif part.visual.kind == "vertex":
        colours = np.asarray(part.visual.vertex_colors)
    else:
        return None
    return colours[:, :3].astype(np.uint8) if len(colours) == len(part.vertices) else None


def _reason(error: BaseException) -> str:
    """The text of an intended error; others concern trimesh's internals."""
    is_said = isinstance(error, ValueError) and bool(str(error).strip())
    return one_line(error) if is_said else "its parts do not fit together"


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh as STL or OFF.

    Raises
    ------
    InputError
        If STL with its 32-bit coordinates is too coarse for the mesh's size.
    """
    ending = path.suffix.lower().removeprefix(".")
    if ending == "stl":
        _check_precision(path, mesh)
    drop_columns([*mesh.attributes], path)
    trimesh = load_extra("trimesh", "mesh")
    shape = trimesh.Trimesh(
        vertices=mesh.vertices, faces=mesh.triangles, vertex_colors=mesh.colours, process=False
    )
    content = shape.export(file_type=ending, **_EXPORTS.get(ending, {}))
    with atomic_path(path) as temporary:
        temporary.write_bytes(content if isinstance(content, bytes) else content.encode())


def _check_precision(path: Path, mesh: Mesh) -> None:
    size = float(np.ptp(mesh.vertices, axis=0).max(initial=0.0))
    error = np.abs(mesh.vertices - mesh.vertices.astype(np.float32)).max(initial=0.0)
    if error > 1e-4 * size:
        raise InputError(
            f"{path}: 32-bit coordinates would move vertices by {error:g}; give .ply, .obj or .glb"
        )


def has_triangles(path: Path) -> bool:
    """True if a file contains triangles, with or without points."""
    return any(len(getattr(part, "faces", ())) for part in _parts(path))


FORMAT = Format(
    read=read, read_mesh=read_mesh, write_mesh=write_mesh, takes=(), has_mesh=has_triangles
)
