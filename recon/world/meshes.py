"""Triangles of PLY and OBJ files."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.libraries import load_open3d
from recon.world.solids import Triangles


def read_mesh(path: Path) -> Triangles:
    """Triangles of a PLY or OBJ file, with its colours and texture coordinates where it has any.

    Raises
    ------
    InputError
        Where there is no file, no triangle, or a coordinate that is not finite.
    """
    mesh = _read(path)
    index = np.asarray(mesh.triangles)
    corners = np.asarray(mesh.vertices)[index]
    if not (len(corners) and np.isfinite(corners).all()):
        raise InputError(f"{path}: {len(corners)} finite triangles, but at least one is needed")
    mesh.compute_vertex_normals()
    uv = np.asarray(mesh.triangle_uvs).reshape(-1, 3, 2) * (1.0, -1.0)
    colours = np.asarray(mesh.vertex_colors)
    return Triangles(
        corners=corners,
        normals=np.asarray(mesh.vertex_normals)[index],
        uv=uv if len(uv) == len(corners) else np.zeros((len(corners), 3, 2)),
        colours=colours[index] if len(colours) else np.ones_like(corners),
    )


def _read(path: Path) -> Any:
    if not path.is_file():
        raise InputError(f"{path}: there is no such file, but a PLY or OBJ mesh is needed")
    o3d = load_open3d()
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        return o3d.io.read_triangle_mesh(str(path))
