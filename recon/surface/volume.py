"""Signed distances to the surface, in blocks of voxels near it (Curless and Levoy, 1996).

Each depth is weighted by its sigma. Open3D's VoxelBlockGrid extracts the triangles from the blocks;
they are filled here, as it does not support pixel weights.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert
from recon.libraries import load_open3d
from recon.records import Mesh
from recon.surface.depth import DepthMap
from recon.surface.integration import BLOCK, NUM_STEPS, Store, View, fuse, touch
from recon.voxelmap.table import CellTable

Array = NDArray[np.float64]
Keys = NDArray[np.int32]

_MAX_SIGMA = 6.0
"""Maximum sigma of a depth, in voxels."""
_MIN_WEIGHT = 0.04
"""Minimum weight of a surface voxel; one view with a sigma of one voxel yields 0.8."""
_MAX_BLOCKS = 2_000_000
_BLOCK = np.dtype([("index", np.int32, (3,))])


class Volume:
    """Signed distances around a surface, fused from depth maps.

    Parameters
    ----------
    voxel : float
        Side of a voxel, world units.
    """

    def __init__(self, voxel: float) -> None:
        self.voxel = voxel
        self._blocks = CellTable(_BLOCK)
        self._store = Store.empty(len(self._blocks.rows))

    @property
    def num_blocks(self) -> int:
        """Number of blocks that were near a surface."""
        return self._blocks.num_rows

    def add(self, view: DepthMap) -> None:
        """Fuse the depths of a view, which also carves free space."""
        sure = view.where(view.sigma <= _MAX_SIGMA * self.voxel)
        if not sure.valid_mask.any():
            return
        self._make_room(sure)
        camera = (view.rig.focal_px, view.rig.cx_left_px, view.rig.cy_px)
        seen = View(sure.depth, sure.sigma, camera, float(np.nanmax(sure.depth)))
        T_left_world = invert(view.T_world_left)
        fuse(self._blocks.used["index"], self._store, seen, T_left_world, self.voxel)

    def _make_room(self, view: DepthMap) -> None:
        """Create the blocks that the surface of a view passes through."""
        mask = view.valid_mask
        rays = view.rig.rays(np.argwhere(mask)[:, ::-1])
        steps = self.voxel / np.linalg.norm(rays, axis=1)
        rays = rays @ view.T_world_left[:3, :3].T
        depth, done = view.depth[mask].astype(np.float64), 0
        side = BLOCK * self.voxel
        while done < len(depth):
            lines = rays / side, view.position / side, depth, steps
            done, num = touch(*self._blocks.arrays, lines, done)
            self._blocks.num_rows = num
            if num > _MAX_BLOCKS:
                raise InputError(
                    f"voxels of {self.voxel:g} make more than {_MAX_BLOCKS} blocks, which do not "
                    "fit into memory: give a larger --voxel"
                )
            if len(self._blocks.rows) - num < NUM_STEPS:
                self._blocks.grow()
        self._store = self._store.for_blocks(len(self._blocks.rows))

    def mesh(self) -> Mesh:
        """The surface where distances change sign, without colours; holes remain."""
        if not (self._store.weight > _MIN_WEIGHT).any():
            return Mesh.none()
        try:
            found = self._grid().extract_triangle_mesh(weight_threshold=_MIN_WEIGHT)
        except RuntimeError as error:
            # Open3D fails at setting colours of a mesh without vertices.
            if "SetVertexColors" not in str(error):
                raise
            return Mesh.none()
        if "positions" not in found.vertex or not len(found.vertex.positions):
            return Mesh.none()
        vertices = found.vertex.positions.numpy().astype(np.float64)
        triangles = found.triangle.indices.numpy().astype(np.int32)
        vertices, triangles = _ordered(vertices, triangles)
        return with_normals(Mesh(vertices=vertices, triangles=triangles))

    def _grid(self) -> Any:
        """Open3D's grid with the same blocks."""
        o3d = load_open3d()
        core = o3d.core
        grid = o3d.t.geometry.VoxelBlockGrid(
            attr_names=("tsdf", "weight"),
            attr_dtypes=(core.float32, core.float32),
            attr_channels=((1), (1)),
            voxel_size=self.voxel,
            block_resolution=BLOCK,
            block_count=self.num_blocks,
        )
        index = np.ascontiguousarray(self._blocks.used["index"])
        rows, _ = grid.hashmap().activate(core.Tensor(index))
        at, cube = rows.numpy(), (-1, BLOCK, BLOCK, BLOCK, 1)
        grid.attribute("tsdf").numpy()[at] = self._store.distance[: len(at)].reshape(cube)
        grid.attribute("weight").numpy()[at] = self._store.weight[: len(at)].reshape(cube)
        return grid


def _ordered(vertices: Array, triangles: Keys) -> tuple[Array, Keys]:
    """The mesh in an order independent of Open3D's threads, with coincident vertices merged."""
    places, number = np.unique(vertices, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles].astype(np.int32)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return places, np.unique(turned, axis=0)


def with_normals(mesh: Mesh) -> Mesh:
    """The mesh with the area-weighted mean normal of the triangles around each vertex."""
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    across = np.cross(b - a, c - a)
    normals = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(normals, mesh.triangles[:, corner], across)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=normals, where=length > 0)
    return Mesh(
        vertices=mesh.vertices, triangles=mesh.triangles, colours=mesh.colours, normals=normals
    )
