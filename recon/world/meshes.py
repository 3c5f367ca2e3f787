"""Triangles of PLY and OBJ files."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.geometry import Array
from recon.libraries import load_open3d
from recon.world.solids import Triangles


def read_mesh(path: Path) -> Triangles:
    """Triangles of a PLY or OBJ file, with its colours and texture coordinates if it has any.

    Raises
    ------
    InputError
        If the file is missing, has no triangles, a face with missing vertices, or a coordinate that
        is not finite.
    """
    mesh = _read(path)
    if "indices" not in mesh.triangle or not len(mesh.triangle.indices):
        raise InputError(f"{path}: no triangle can be read, but at least one is needed")
    index = mesh.triangle.indices.numpy()
    num = len(mesh.vertex.positions)
    if index.min() < 0 or index.max() >= num:
        raise InputError(
            f"{path}: a face uses vertices {index.min()} to {index.max()}, but there are {num}"
        )
    corners = mesh.vertex.positions.numpy().astype(np.float64)[index]
    if not np.isfinite(corners).all():
        raise InputError(f"{path}: a corner is not finite, but all must be")
    mesh.compute_vertex_normals()
    return Triangles(
        corners=corners,
        normals=mesh.vertex.normals.numpy().astype(np.float64)[index],
        uv=_uv(mesh, len(corners)),
        colours=_colours(mesh)[index],
    )


def _read(path: Path) -> Any:
    if not path.is_file():
        raise InputError(f"{path}: there is no such file, but a PLY or OBJ mesh is needed")
    o3d = load_open3d()
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        return o3d.t.io.read_triangle_mesh(str(path))


def _uv(mesh: Any, count: int) -> Array:
    """Texture coordinates (T, 3, 2); files count v upwards."""
    if "texture_uvs" not in mesh.triangle:
        return np.zeros((count, 3, 2))
    uv: Array = mesh.triangle.texture_uvs.numpy() * np.array([1.0, -1.0])
    return uv


def _colours(mesh: Any) -> Array:
    """Red, green, blue (V, 3) of the vertices, 0 to 1."""
    if "colors" not in mesh.vertex:
        return np.ones((len(mesh.vertex.positions), 3))
    colours = mesh.vertex.colors.numpy()
    scale = 255.0 if colours.dtype == np.uint8 else 1.0
    share: Array = (colours / scale).clip(0.0, 1.0)
    return share
