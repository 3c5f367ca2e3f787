"""Closing of meshes with unobserved surface."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.libraries import load_open3d
from recon.records import Mesh
from recon.surface.triangles import with_normals

Edges = NDArray[np.int32]

_POISSON_DEPTH = 9


def watertight(mesh: Mesh) -> Mesh:
    """A closed surface through the mesh: screened Poisson (Kazhdan and Hoppe, 2013), and caps.

    Where the surface is unobserved, Poisson's surface extends to the sides of a box around the
    mesh; there it is open, and is capped. Where it touches itself, it is cut open and capped, too,
    so that every edge has two triangles.
    """
    o3d = load_open3d()
    cloud = o3d.geometry.PointCloud()
    cloud.points = o3d.utility.Vector3dVector(mesh.vertices)
    cloud.normals = o3d.utility.Vector3dVector(with_normals(mesh).normals)
    if mesh.colours is not None:
        cloud.colors = o3d.utility.Vector3dVector(mesh.colours / 255.0)
    found, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(
        cloud, depth=_POISSON_DEPTH, n_threads=1
    )
    closed = _from_open3d(found)
    if mesh.colours is None:  # the Poisson surface has black ones
        closed = replace(closed, colours=None)
    return with_normals(capped(without_touching(closed)))


def thickness(mesh: Mesh) -> float:
    """Twice the enclosed volume of a closed mesh over its area: the thickness of a plate."""
    a, b, c = np.moveaxis(mesh.corners - mesh.vertices.mean(axis=0), 1, 0)
    volume = abs(float((a * np.cross(b, c)).sum())) / 6
    return 2 * volume / mesh.area


def border_edges(mesh: Mesh) -> Edges:
    """(E, 2) edges of only one triangle, in its direction."""
    border: Edges = _edges(mesh)[edge_counts(mesh) == 1]
    return border


def edge_counts(mesh: Mesh) -> NDArray[np.int64]:
    """(3 T,) number of triangles at each edge of each triangle."""
    _, same, count = np.unique(
        np.sort(_edges(mesh), axis=1), axis=0, return_inverse=True, return_counts=True
    )
    counts: NDArray[np.int64] = count[same.reshape(-1)]
    return counts


def without_touching(mesh: Mesh) -> Mesh:
    """The mesh without the triangles at edges of more than two."""
    return mesh.select(edge_counts(mesh).reshape(-1, 3).max(axis=1) <= 2)


def _edges(mesh: Mesh) -> Edges:
    """(3 T, 2) the edges of each triangle, in its direction."""
    edges: Edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return edges


def capped(mesh: Mesh) -> Mesh:
    """The mesh with a fan of triangles over every loop of border edges, around its centre."""
    loops = list(_loops(border_edges(mesh)))
    if not loops:
        return mesh
    num = len(mesh.vertices)
    middles = np.array([mesh.vertices[loop[:, 0]].mean(axis=0) for loop in loops])
    # Opposite to the direction of the adjacent triangles.
    fans = [
        np.column_stack([loop[:, ::-1], np.full(len(loop), num + number)])
        for number, loop in enumerate(loops)
    ]
    colours = mesh.colours
    if colours is not None:
        tints = [np.rint(colours[loop[:, 0]].mean(axis=0)).astype(np.uint8) for loop in loops]
        colours = np.concatenate([colours, tints])
    return Mesh(
        vertices=np.concatenate([mesh.vertices, middles]),
        triangles=np.concatenate([mesh.triangles, *fans]).astype(np.int32),
        colours=colours,
    )


def _loops(edges: Edges) -> Iterator[Edges]:
    """The closed loops of directed edges, as their edges in order; none meets a vertex twice."""
    ahead: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        ahead.setdefault(start, []).append(end)
    while ahead:
        path = [next(iter(ahead))]
        place = {path[0]: 0}
        while path[-1] in ahead:
            there = _taken(ahead, path[-1])
            if there not in place:
                place[there] = len(path)
                path.append(there)
                continue
            loop = path[place[there] :]
            del path[place[there] + 1 :]
            for vertex in loop[1:]:
                del place[vertex]
            yield np.array([loop, [*loop[1:], there]], np.int32).T


def _taken(ahead: dict[int, list[int]], here: int) -> int:
    """Remove one edge from here, and return its end."""
    there = ahead[here].pop()
    if not ahead[here]:
        del ahead[here]
    return there


def _from_open3d(mesh: Any) -> Mesh:
    colours = np.rint(np.asarray(mesh.vertex_colors) * 255).astype(np.uint8)
    return Mesh(
        vertices=np.asarray(mesh.vertices),
        triangles=np.asarray(mesh.triangles).astype(np.int32),
        colours=colours if len(colours) else None,
    )
