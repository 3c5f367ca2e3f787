"""Cells for viewing in any browser: their exposed faces as glTF (GLB), by trimesh; y up."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports import meshes
from recon.exports.format import Format
from recon.exports.numbers import drop_columns
from recon.files import atomic_path
from recon.libraries import load_extra
from recon.records import Mesh, PointCloud, Voxels
from recon.voxelmap.faces import exposed_faces

_NEAR = 16.0
"""Distance from the origin, in extents, up to which 32 bits are precise enough."""


def write(path: Path, data: PointCloud | Voxels) -> None:
    """Write the outer faces of the cells, or points, in their colours."""
    if isinstance(data, PointCloud) and not len(data):
        raise InputError(f"there is nothing to write to {path.name}, but a point is needed")
    if isinstance(data, PointCloud):
        drop_columns([*data.attributes, *(["sigma"] if data.sigma is not None else [])], path)
        _write(path, data.points, lambda trimesh, places: _points(trimesh, data, places))
        return
    faces = exposed_faces(data)
    corners = faces.vertices.reshape(-1, 3)
    triangles = np.arange(len(corners)).reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    colours = np.repeat(faces.colours, 4, axis=0)
    _write(path, corners, lambda trimesh, places: _shape(trimesh, places, triangles, colours))


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write triangles in the colours of their vertices."""
    drop_columns([*mesh.attributes], path)
    _write(
        path,
        mesh.vertices,
        lambda trimesh, places: _shape(trimesh, places, mesh.triangles, mesh.colours),
    )


def _write(path: Path, places: NDArray[np.float64], shape: Callable[[Any, Any], Any]) -> None:
    """Write the result of `shape` for positions; glTF stores 32 bits, so a node adds an offset."""
    trimesh = load_extra("trimesh", "mesh")
    offset = _offset(places)
    transform = np.eye(4)
    transform[:3, 3] = offset
    scene = trimesh.Scene()
    scene.add_geometry(shape(trimesh, places - offset), transform=transform)
    content = trimesh.exchange.gltf.export_glb(scene, tree_postprocessor=_make_matt)
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


def _offset(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The integer offset (3,); 0 if positions are near the origin relative to their extent."""
    if not len(places):
        return np.zeros(3)
    low, high = places.min(axis=0), places.max(axis=0)
    is_near = np.abs([low, high]).max() <= _NEAR * max(float((high - low).max()), 1.0)
    return np.zeros(3) if is_near else np.rint((low + high) / 2.0)


def _shape(trimesh: Any, places: Any, triangles: Any, colours: Any) -> Any:
    return trimesh.Trimesh(vertices=places, faces=triangles, vertex_colors=colours, process=False)


def _points(trimesh: Any, cloud: PointCloud, places: Any) -> Any:
    return trimesh.PointCloud(places, colors=cloud.colours)


def _make_matt(tree: dict[str, Any]) -> None:
    """Set a matt material: by default viewers show metal, which is black without lights."""
    tree["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}]
    for mesh in tree.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive["material"] = 0


FORMAT = Format(
    write=write, read=meshes.read, read_mesh=meshes.read_mesh, write_mesh=write_mesh,
    has_mesh=meshes.has_triangles,
)  # fmt: skip
