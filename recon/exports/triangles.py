"""Triangles from the faces of other programs, and points sampled on them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports.columns import NORMAL, cloud_in
from recon.exports.numbers import drop_columns
from recon.records import Mesh, PointCloud

Faces = NDArray[Any] | Sequence[NDArray[Any]]
"""Vertex indices: (F, K), or one array per face."""


def mesh_of(columns: Mapping[str, NDArray[Any]], faces: Faces) -> Mesh:
    """The mesh from vertices as columns, and faces of three or more corners.

    Raises
    ------
    InputError
        If there are no faces, or one refers to a missing vertex.
    """
    cloud = cloud_in(columns)
    check_faces(faces, len(cloud))
    triangles = fans(faces)
    if not len(triangles):
        raise InputError("it holds no faces, but a mesh is needed")
    normals = [cloud.attributes[name] for name in NORMAL if name in cloud.attributes]
    return Mesh(
        vertices=cloud.points,
        triangles=triangles,
        colours=cloud.colours,
        normals=np.column_stack(normals).astype(float) if len(normals) == 3 else None,
        attributes={n: values for n, values in cloud.attributes.items() if n not in NORMAL},
    )


def check_faces(faces: Faces, num_vertices: int) -> None:
    """Raise `InputError` if a face refers to a missing vertex."""
    if not len(faces):
        return
    named = faces.reshape(-1) if isinstance(faces, np.ndarray) else np.concatenate(faces)
    lowest, highest = float(named.min(initial=0)), float(named.max(initial=0))
    if lowest < 0 or highest >= max(num_vertices, 1):
        wrong = lowest if lowest < 0 else highest
        raise InputError(f"a face names vertex {wrong:.0f}, but there are {num_vertices}")


def fans(faces: Faces) -> NDArray[np.int32]:
    """Triangles (T, 3) of faces, each a fan around its first corner."""
    by_length: dict[int, Any] = {}
    if isinstance(faces, np.ndarray):
        by_length[faces.shape[1]] = faces
    else:
        for face in faces:
            by_length.setdefault(len(face), []).append(face)
    triangles = [
        np.asarray(rows)[:, [0, n, n + 1]].reshape(-1, 3)
        for length, rows in by_length.items()
        for n in range(1, length - 1)
    ]
    if not triangles:
        return np.zeros((0, 3), np.int32)
    return np.concatenate(triangles).astype(np.int32)


def sampled(mesh: Mesh, num: int, rng: np.random.Generator) -> PointCloud:
    """`num` points evenly over the surface, with colours and normals between those of the corners.

    Raises
    ------
    InputError
        If the surface has no area.
    """
    areas = mesh.triangle_areas
    if not areas.sum() > 0:
        raise InputError("the triangles have no area, but points on them are requested")
    drop_columns([*mesh.attributes], "points on the triangles")
    rows = rng.choice(len(areas), num, p=areas / areas.sum())
    # Uniform in a triangle: the square root of one random number, and another along it.
    root, share = np.sqrt(rng.random(num)), rng.random(num)
    weights = np.column_stack([1.0 - root, root * (1.0 - share), root * share])

    def between(values: NDArray[Any]) -> NDArray[np.float64]:
        mixed: NDArray[np.float64] = np.einsum("nc,nck->nk", weights, values[mesh.triangles[rows]])
        return mixed

    attributes = {}
    if mesh.normals is not None:
        attributes = dict(zip(NORMAL, between(mesh.normals).T, strict=True))
    return PointCloud(
        points=between(mesh.vertices),
        colours=None if mesh.colours is None else np.rint(between(mesh.colours)).astype(np.uint8),
        attributes=attributes,
    )
