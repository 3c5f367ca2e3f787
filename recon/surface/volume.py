"""Signed distances to the surface, in blocks of voxels near it (Curless and Levoy, 1996).

Each depth counts by its sigma. Open3D's VoxelBlockGrid makes triangles of the blocks; they are
filled here, as it knows no weights of pixels.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.errors import InputError
from recon.geometry import invert
from recon.libraries import load_open3d
from recon.records import Mesh
from recon.surface.depth import DepthMap, Floats

Array = NDArray[np.float64]
Keys = NDArray[np.int32]

BLOCK = 8
"""Voxels along each side of a block."""
TRUNCATION = 4.0
"""Voxels before the surface from which on distance is no longer measured."""
_BEHIND = 3.0
"""Voxels behind the surface of which a view still says something."""
_MAX_SIGMA = 6.0
"""Depths less sure than so many voxels are left out."""
_FREE_SHARE = 0.3
"""What a view's word on free space is worth, of its word on the surface."""
_MIN_WEIGHT = 0.04
"""Of a voxel with a surface; one view with a sigma of a voxel gives 0.8."""
_JUMP = 2.0
"""Voxels of depth between neighbouring pixels that are taken for two surfaces."""
_MAX_BLOCKS = 2_000_000
_KEY_OFFSET, _KEY_BITS = 1 << 20, 21


class _Store(NamedTuple):
    """What the voxels of B blocks hold."""

    distance: Floats
    """(B, V) in truncations, positive before the surface."""
    weight: Floats
    """(B, V)"""
    colour: Floats
    """(B, V, 4) weighted sums of red, green and blue near the surface, and of the weights."""


class _View(NamedTuple):
    """A depth map as the loops want it."""

    depth: Floats
    sigma: Floats
    colours: NDArray[np.uint8]
    camera: tuple[float, float, float]
    """Focal length and principal point, pixels."""


class Volume:
    """Signed distances round a surface, fused from depth maps.

    Parameters
    ----------
    voxel : float
        Side of a voxel, world units.
    """

    def __init__(self, voxel: float) -> None:
        self.voxel = voxel
        self._codes = np.zeros(0, np.int64)
        self._distance = np.zeros((0, BLOCK**3), np.float32)
        self._weight = np.zeros((0, BLOCK**3), np.float32)
        self._colour = np.zeros((0, BLOCK**3, 4), np.float32)

    @property
    def num_blocks(self) -> int:
        """Blocks that have been near a surface."""
        return len(self._codes)

    def add(self, view: DepthMap) -> None:
        """Fuse the depths of a view; it carves free space out of what is there, too."""
        sure = view.where(view.sigma <= _MAX_SIGMA * self.voxel)
        self._make_room(sure)
        T_left_world = invert(view.T_world_left)
        camera = (view.rig.focal_px, view.rig.cx_left_px, view.rig.cy_px)
        store = _Store(self._distance, self._weight, self._colour)
        seen = _View(sure.depth, sure.sigma, sure.colours, camera)
        _fuse(_decoded(self._codes), store, seen, T_left_world, self.voxel)

    def _make_room(self, view: DepthMap) -> None:
        """Begin the blocks that the surface of a view runs through."""
        rays = view.rig.rays(np.argwhere(view.valid_mask)[:, ::-1])
        depth = view.depth[view.valid_mask].astype(np.float64)
        length = np.linalg.norm(rays, axis=1)
        found = [self._codes]
        for step in np.arange(-TRUNCATION, TRUNCATION + 1, BLOCK / 2):
            z = depth + step * self.voxel / length
            points = (rays * z[:, None]) @ view.T_world_left[:3, :3].T + view.position
            found.append(np.unique(_coded(np.floor(points / (BLOCK * self.voxel)))))
        codes = np.unique(np.concatenate(found))
        if len(codes) > _MAX_BLOCKS:
            raise InputError(
                f"voxels of {self.voxel:g} make {len(codes)} blocks, but at most {_MAX_BLOCKS} "
                "fit into memory: give a larger --voxel"
            )
        if len(codes) > len(self._codes):
            self._grow(codes)

    def _grow(self, codes: NDArray[np.int64]) -> None:
        rows = np.searchsorted(codes, self._codes)
        for name in ("_distance", "_weight", "_colour"):
            old = getattr(self, name)
            new = np.zeros((len(codes), *old.shape[1:]), np.float32)
            new[rows] = old
            setattr(self, name, new)
        self._codes = codes

    def mesh(self) -> Mesh:
        """The surface where distances change their sign, with colours; holes stay holes."""
        if not (self._weight > _MIN_WEIGHT).any():
            return Mesh.none()
        grid = self._grid()
        found = grid.extract_triangle_mesh(weight_threshold=_MIN_WEIGHT)
        if "positions" not in found.vertex or not len(found.vertex.positions):
            return Mesh.none()
        vertices = found.vertex.positions.numpy().astype(np.float64)
        triangles = found.triangle.indices.numpy().astype(np.int32)
        vertices, triangles = _ordered(vertices, triangles)
        return with_normals(
            Mesh(vertices=vertices, triangles=triangles, colours=self._colours_at(vertices))
        )

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
        rows, _ = grid.hashmap().activate(core.Tensor(_decoded(self._codes)))
        at = rows.numpy()
        cube = (-1, BLOCK, BLOCK, BLOCK, 1)
        grid.attribute("tsdf").numpy()[at] = self._distance.reshape(cube)
        grid.attribute("weight").numpy()[at] = self._weight.reshape(cube)
        return grid

    def _colours_at(self, points: Array) -> NDArray[np.uint8]:
        """(N, 3) mean colour of the voxel next to each point."""
        voxels = np.rint(points / self.voxel).astype(np.int64)
        blocks, inside = np.divmod(voxels, BLOCK)
        row = np.searchsorted(self._codes, _coded(blocks))
        row = np.minimum(row, self.num_blocks - 1)
        x, y, z = inside.T
        colour = self._colour[row, (z * BLOCK + y) * BLOCK + x]
        mean = colour[:, :3] / np.maximum(colour[:, 3:], 1e-9)
        colours: NDArray[np.uint8] = np.rint(mean).clip(0, 255).astype(np.uint8)
        return colours


def _ordered(vertices: Array, triangles: Keys) -> tuple[Array, Keys]:
    """The mesh in an order that does not hang on Open3D's threads, vertices of one place as one."""
    places, number = np.unique(vertices, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles].astype(np.int32)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return places, np.unique(turned, axis=0)


def with_normals(mesh: Mesh) -> Mesh:
    """The mesh with the mean normal of the triangles round each vertex, by area."""
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


def _coded(blocks: NDArray[np.number]) -> NDArray[np.int64]:
    """Blocks (N, 3) as single numbers."""
    x, y, z = blocks.astype(np.int64).T + _KEY_OFFSET
    codes: NDArray[np.int64] = (x << 2 * _KEY_BITS) + (y << _KEY_BITS) + z
    return codes


def _decoded(codes: NDArray[np.int64]) -> Keys:
    mask = (1 << _KEY_BITS) - 1
    parts = [codes >> 2 * _KEY_BITS, (codes >> _KEY_BITS) & mask, codes & mask]
    return np.ascontiguousarray(np.stack(parts, axis=1) - _KEY_OFFSET).astype(np.int32)


@njit(cache=True, nogil=True, error_model="numpy")
def _fuse(blocks: Keys, store: _Store, view: _View, T_left_world: Array, voxel: float) -> None:
    """Add what a view says of every voxel of every block."""
    steps, shift = T_left_world[:3, :3] * voxel, T_left_world[:3, 3]
    for b in range(len(blocks)):
        x, y, z = blocks[b, 0] * BLOCK, blocks[b, 1] * BLOCK, blocks[b, 2] * BLOCK
        corner = steps[:, 0] * x + steps[:, 1] * y + steps[:, 2] * z + shift
        for k in range(BLOCK**3):
            x, y, z = k % BLOCK, k // BLOCK % BLOCK, k // BLOCK**2
            place = corner + steps[:, 0] * x + steps[:, 1] * y + steps[:, 2] * z
            _see(b, k, place, store, view, voxel)


@njit(cache=True, nogil=True, error_model="numpy")
def _see(b: int, k: int, place: Array, store: _Store, view: _View, voxel: float) -> None:
    """Add what a view says of one voxel, whose place is in the view's frame."""
    focal, cx, cy = view.camera
    u, v = focal * place[0] / place[2] + cx, focal * place[1] / place[2] + cy
    height, width = view.depth.shape
    if not (place[2] > 0 and 0 <= u < width - 1 and 0 <= v < height - 1):
        return
    ahead = (_depth_at(view.depth, u, v, _JUMP * voxel) - place[2]) / voxel
    if not ahead >= -_BEHIND:  # nothing is known there, either
        return
    column, row = int(u + 0.5), int(v + 0.5)
    spread = view.sigma[row, column] / voxel
    trust = 1 / (spread * spread + 0.25)
    if ahead > TRUNCATION:
        trust *= _FREE_SHARE
    else:
        store.colour[b, k, 3] += trust
        for c in range(3):
            store.colour[b, k, c] += trust * view.colours[row, column, c]
    store.weight[b, k] += trust
    old = store.distance[b, k]
    new = min(ahead / TRUNCATION, 1.0)
    store.distance[b, k] = old + (new - old) * trust / store.weight[b, k]


@njit(cache=True, nogil=True, error_model="numpy")
def _depth_at(depth: Floats, u: float, v: float, jump: float) -> float:
    """Depth between four pixels; that of the nearest one where they are of two surfaces."""
    column, row = int(u), int(v)
    a, b = depth[row, column], depth[row, column + 1]
    c, d = depth[row + 1, column], depth[row + 1, column + 1]
    x, y = u - column, v - row
    found: float = depth[int(v + 0.5), int(u + 0.5)]
    if max(max(a, b), max(c, d)) - min(min(a, b), min(c, d)) <= jump:
        found = (a * (1 - x) + b * x) * (1 - y) + (c * (1 - x) + d * x) * y
    return found
