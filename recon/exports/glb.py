"""An image of the cells for any browser: their exposed faces as glTF (GLB), by trimesh; y up."""

from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.files import atomic_path
from recon.libraries import load_extra
from recon.records import PointCloud, Voxels
from recon.voxelmap.faces import exposed_faces


def write(path: Path, data: PointCloud | Voxels) -> None:
    """Write the outside of the cells, or points, in their colours."""
    if isinstance(data, PointCloud) and not len(data):
        raise InputError(f"nothing is there to be written as {path.name}, but a point is needed")
    trimesh = load_extra("trimesh", "mesh")
    scene = trimesh.Scene(
        _points(trimesh, data) if isinstance(data, PointCloud) else _faces(trimesh, data)
    )
    content = trimesh.exchange.gltf.export_glb(scene, tree_postprocessor=_make_matt)
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


def _faces(trimesh: Any, voxels: Voxels) -> Any:
    faces = exposed_faces(voxels)
    triangles = np.arange(4 * len(faces)).reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return trimesh.Trimesh(
        vertices=faces.vertices.reshape(-1, 3),
        faces=triangles,
        vertex_colors=np.repeat(faces.colours, 4, axis=0),
        process=False,
    )


def _points(trimesh: Any, cloud: PointCloud) -> Any:
    return trimesh.PointCloud(cloud.points, colors=cloud.colours)


def _make_matt(tree: dict[str, Any]) -> None:
    """Without a material of its own a viewer shows metal, which is black where nothing shines."""
    tree["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}]
    for mesh in tree.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive["material"] = 0
