"""Signed distances of voxels near a surface, from depth maps (Curless and Levoy, 1996)."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.surface.depth import Floats
from recon.voxelmap.table import Rows, Slots, find_or_add

Array = NDArray[np.float64]
Keys = NDArray[np.int32]
Place = tuple[float, float, float]

BLOCK = 8
"""Voxels along each side of a block."""
TRUNCATION = 4.0
"""Truncation of distances in front of the surface, in voxels."""
_BEHIND = 3.0
"""Distance behind the surface up to which a view is informative, in voxels."""
_FREE_SHARE = 0.3
"""Weight of a view's free space, relative to that of its surface."""
_JUMP = 2.0
"""Depth difference of neighbouring pixels that separates surfaces, in voxels."""


_STEPS = np.arange(-TRUNCATION, TRUNCATION + 1, BLOCK / 2)
"""Distances from a surface at which its rays are sampled for blocks, in voxels."""
NUM_STEPS = len(_STEPS)


class Store(NamedTuple):
    """Voxels of B blocks, V voxels each, x first."""

    distance: Floats
    """(B, V) in truncations, positive in front of the surface."""
    weight: Floats
    """(B, V)"""

    @classmethod
    def empty(cls, num_blocks: int) -> "Store":
        """Unobserved voxels of `num_blocks` blocks."""
        return cls(*(np.zeros((num_blocks, BLOCK**3), np.float32) for _ in cls._fields))

    def for_blocks(self, num_blocks: int) -> "Store":
        """The same voxels, with room for `num_blocks` blocks."""
        if num_blocks > len(self.weight):
            for array in self:
                # resize() may move the block without a copy; no other reference to the array
                # exists.
                array.resize((num_blocks, BLOCK**3), refcheck=False)
        return self


class View(NamedTuple):
    """A depth map in the layout of the loops."""

    depth: Floats
    sigma: Floats
    camera: tuple[float, float, float]
    """Focal length and principal point, pixels."""
    farthest: float
    """The largest depth."""


@njit(cache=True, nogil=True, error_model="numpy")
def touch(
    slots: Slots, blocks: Rows, num: int, lines: tuple[Array, Array, Array, Array], first: int
) -> tuple[int, int]:
    """Enter the blocks that rays hit near their depth, until the table is nearly full.

    Rays (at depth 1) and their origin are in blocks; `lines` also has their depths, and the change
    of depth over a voxel's length. Returns the next ray, and the number of blocks.
    """
    rays, start, depth, steps = lines
    last = np.full((NUM_STEPS, 3), np.inf)
    for k in range(first, len(depth)):
        if len(blocks) - num < NUM_STEPS:
            return k, num
        for s in range(NUM_STEPS):
            z = depth[k] + _STEPS[s] * steps[k]
            x, y, z = (
                np.floor(rays[k, 0] * z + start[0]),
                np.floor(rays[k, 1] * z + start[1]),
                np.floor(rays[k, 2] * z + start[2]),
            )
            # Neighbouring pixels mostly hit the same blocks.
            if not (x == last[s, 0] and y == last[s, 1] and z == last[s, 2]):
                last[s, 0], last[s, 1], last[s, 2] = x, y, z
                _, num = find_or_add(slots, blocks, num, (int(x), int(y), int(z)))
    return len(depth), num


@njit(cache=True, nogil=True, error_model="numpy")
def fuse(blocks: Keys, store: Store, view: View, T_left_world: Array, voxel: float) -> None:
    """Add the evidence of a view to every voxel of every visible block."""
    T, side = T_left_world, BLOCK * voxel
    for b in range(len(blocks)):
        x, y, z = blocks[b, 0] * side, blocks[b, 1] * side, blocks[b, 2] * side
        corner = (
            T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3],
            T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3],
            T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3],
        )
        if _is_in_sight(corner, T, view, voxel):
            _fuse_block(b, corner, T, store, view, voxel)


@njit(cache=True, nogil=True, error_model="numpy")
def _is_in_sight(corner: Place, T: Array, view: View, voxel: float) -> bool:
    """False if a view has no evidence for any voxel of a block, given by its corner."""
    half = 0.5 * BLOCK * voxel
    x = corner[0] + half * (T[0, 0] + T[0, 1] + T[0, 2])
    y = corner[1] + half * (T[1, 0] + T[1, 1] + T[1, 2])
    z = corner[2] + half * (T[2, 0] + T[2, 1] + T[2, 2])
    radius = np.sqrt(3.0) * half
    if z + radius <= 0 or z - radius > view.farthest + _BEHIND * voxel:
        return False
    focal, cx, cy = view.camera
    height, width = view.depth.shape
    right, low = width - 1 - cx, height - 1 - cy
    # Distances to the sides of the viewing frustum.
    return not (
        focal * x + cx * z < -radius * np.hypot(focal, cx)
        or right * z - focal * x < -radius * np.hypot(focal, right)
        or focal * y + cy * z < -radius * np.hypot(focal, cy)
        or low * z - focal * y < -radius * np.hypot(focal, low)
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _fuse_block(
    b: int,
    corner: Place,
    T: Array,
    store: Store,
    view: View,
    voxel: float,
) -> None:
    for k in range(BLOCK**3):
        x, y, z = voxel * (k % BLOCK), voxel * (k // BLOCK % BLOCK), voxel * (k // BLOCK**2)
        place = (
            corner[0] + T[0, 0] * x + T[0, 1] * y + T[0, 2] * z,
            corner[1] + T[1, 0] * x + T[1, 1] * y + T[1, 2] * z,
            corner[2] + T[2, 0] * x + T[2, 1] * y + T[2, 2] * z,
        )
        _see(b, k, place, store, view, voxel)


@njit(cache=True, nogil=True, error_model="numpy")
def _see(
    b: int,
    k: int,
    place: Place,
    store: Store,
    view: View,
    voxel: float,
) -> None:
    """Add the evidence of a view to one voxel, whose position is in the view's frame."""
    if not place[2] > 0:
        return
    focal, cx, cy = view.camera
    u, v = focal * place[0] / place[2] + cx, focal * place[1] / place[2] + cy
    height, width = view.depth.shape
    if not (0 <= u < width - 1 and 0 <= v < height - 1):
        return
    column, row = int(u + 0.5), int(v + 0.5)
    # Four pixels differ by no more than a jump, otherwise only the nearest counts.
    if not (view.depth[row, column] - place[2]) / voxel >= -_BEHIND - _JUMP:
        return
    ahead = (_depth_at(view.depth, u, v, _JUMP * voxel) - place[2]) / voxel
    if not ahead >= -_BEHIND:  # also if the depth is unknown
        return
    spread = view.sigma[row, column] / voxel
    trust = 1 / (spread * spread + 0.25)
    if ahead > TRUNCATION:
        trust *= _FREE_SHARE
    store.weight[b, k] += trust
    old = store.distance[b, k]
    new = min(ahead / TRUNCATION, 1.0)
    store.distance[b, k] = old + (new - old) * trust / store.weight[b, k]


@njit(cache=True, nogil=True, error_model="numpy")
def _depth_at(depth: Floats, u: float, v: float, jump: float) -> float:
    """Depth interpolated between four pixels; that of the nearest one across two surfaces."""
    column, row = int(u), int(v)
    a, b = depth[row, column], depth[row, column + 1]
    c, d = depth[row + 1, column], depth[row + 1, column + 1]
    x, y = u - column, v - row
    found: float = depth[int(v + 0.5), int(u + 0.5)]
    if max(max(a, b), max(c, d)) - min(min(a, b), min(c, d)) <= jump:
        found = (a * (1 - x) + b * x) * (1 - y) + (c * (1 - x) + d * x) * y
    return found
