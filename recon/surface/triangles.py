"""Creation and cleaning of meshes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from recon.records import Mesh
from recon.surface.depth import DepthMap

SMALLEST_SHARE = 0.01
"""Minimum share of the area of a piece; smaller ones are removed as floaters."""
_NUM_SIGMAS = 3.0
_STEEPEST = 3.0
"""Maximum depth difference of neighbouring pixels of one surface, in pixel widths at that depth."""


def vertex_pieces(mesh: Mesh) -> NDArray[np.int64]:
    """(V,) index of the connected piece of each vertex."""
    a, b, c = mesh.triangles.T
    edges = np.concatenate([np.stack([a, b]), np.stack([b, c])], axis=1)
    ones = np.ones(edges.shape[1], np.int8)
    graph = coo_array((ones, tuple(edges)), shape=(len(mesh.vertices),) * 2)
    found: NDArray[np.int64] = connected_components(graph, directed=False)[1].astype(np.int64)
    return found


def piece_areas(mesh: Mesh, piece: NDArray[np.int64]) -> NDArray[np.float64]:
    """Area of each connected piece, given those of the vertices (V,)."""
    areas: NDArray[Any] = np.bincount(piece[mesh.triangles[:, 0]], weights=mesh.triangle_areas)
    return areas.astype(np.float64)


def without_floaters(mesh: Mesh, smallest_share: float = SMALLEST_SHARE) -> Mesh:
    """The mesh without connected pieces that have less than a share of its area."""
    if not len(mesh):
        return mesh
    piece = vertex_pieces(mesh)
    areas = piece_areas(mesh, piece)
    return mesh.select(areas[piece[mesh.triangles[:, 0]]] >= smallest_share * areas.sum())


def mesh_of_pixels(view: DepthMap) -> Mesh:
    """Triangles between neighbouring pixels of one view, cut where the depth jumps."""
    mask = view.valid_mask
    number = np.full(mask.shape, -1, np.int32)
    number[mask] = np.arange(mask.sum(), dtype=np.int32)
    a, b = number[:-1, :-1], number[:-1, 1:]
    c, d = number[1:, :-1], number[1:, 1:]
    triangles = np.concatenate(
        [np.stack([a, c, b], axis=-1).reshape(-1, 3), np.stack([b, c, d], axis=-1).reshape(-1, 3)]
    )
    triangles = triangles[(triangles >= 0).all(axis=1)]
    depth, sigma = view.depth[mask].astype(np.float64), view.sigma[mask]
    between = depth[triangles]
    limit = _STEEPEST * between.min(axis=1) / view.rig.focal_px * np.sqrt(2)
    limit += _NUM_SIGMAS * sigma[triangles].min(axis=1)
    whole = triangles[np.ptp(between, axis=1) <= limit]
    mesh = Mesh(vertices=view.points(mask), triangles=whole, colours=view.colours[mask])
    # Unused vertices are removed.
    return with_normals(mesh.select(np.ones(len(mesh), bool)))


def with_normals(mesh: Mesh) -> Mesh:
    """The mesh with the area-weighted mean normal of the triangles around each vertex."""
    across, normals = mesh.crosses, np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(normals, mesh.triangles[:, corner], across)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=normals, where=length > 0)
    return Mesh(
        vertices=mesh.vertices, triangles=mesh.triangles, colours=mesh.colours, normals=normals
    )
