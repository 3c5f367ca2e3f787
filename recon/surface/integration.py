"""Signed distances of voxels near a surface, from depth maps (Curless and Levoy, 1996)."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.surface.depth import Camera, Floats
from recon.voxelmap.table import Rows, Slots, find_or_add

Array = NDArray[np.float64]
Keys = NDArray[np.int32]
Place = tuple[float, float, float]

BLOCK = 8
"""Voxels along each side of a block."""
TRUNCATION = 4.0
"""Distances farther before the surface than so many voxels are not told apart."""
_BEHIND, _SIGMAS_BEHIND = 3.0, 2.0
"""Distance behind the surface up to which a view is informative, in voxels or, if larger, sigmas:
otherwise depths that are too large make a second surface behind the first."""
_FREE_SHARE, _BEHIND_SHARE = 0.3, 0.2
"""Weights of a view farther in front of and behind its surface, relative to that near it."""
_SIGMAS_BEFORE = 3.0
"""Truncation of distances in front of an unsure surface, in sigmas."""
MAX_SIGMA = 6.0
"""Maximum sigma of a depth, in voxels."""
DEEPEST = _SIGMAS_BEHIND * MAX_SIGMA
"""Maximum distance behind a surface at which a view is informative, in voxels."""
_JUMP = 2.0
"""Depth difference of neighbouring pixels that separates surfaces, in voxels."""


_STEPS = np.arange(-TRUNCATION, TRUNCATION + 1, BLOCK / 2)
"""Distances from a surface at which its rays are sampled for blocks, in voxels."""
NUM_STEPS = len(_STEPS)


UNITS = 1 << 13
"""Resolution of weights; integer sums of parts can be added exactly."""
_FULL = np.int32((2**31 - 1) * TRUNCATION / (_SIGMAS_BEFORE * MAX_SIGMA) - 4 * UNITS)
"""Maximum weight of a voxel; larger sums of distances would overflow."""
VOXELS = np.dtype(
    [("index", np.int32, (3,)), ("distance", np.int32, BLOCK**3), ("weight", np.int32, BLOCK**3)]
)
"""A block: for each voxel, x first, the weighted sum of distances in truncations, positive in front
of the surface, and the sum of weights."""


class View(NamedTuple):
    """A depth map in the layout of the loops."""

    depth: Floats
    sigma: Floats
    camera: Camera
    farthest: float
    """The largest depth."""


@njit(cache=True, nogil=True, error_model="numpy")
def touch(
    slots: Slots, blocks: Rows, num: int, points: Array, start: Array, first: int
) -> tuple[int, int]:
    """Enter the blocks that rays hit near their ends, until the table is nearly full.

    The ends (N, 3) and the common start of the rays are in blocks. Returns the next ray, and the
    number of blocks.
    """
    last = np.full((NUM_STEPS, 3), np.inf)
    for k in range(first, len(points)):
        if len(blocks) - num < NUM_STEPS:
            return k, num
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        along = x - start[0], y - start[1], z - start[2]
        one = 1 / (BLOCK * np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2))
        for s in range(NUM_STEPS):
            step = _STEPS[s] * one
            i, j, m = (
                np.floor(x + step * along[0]),
                np.floor(y + step * along[1]),
                np.floor(z + step * along[2]),
            )
            # Neighbouring pixels mostly hit the same blocks.
            if not (i == last[s, 0] and j == last[s, 1] and m == last[s, 2]):
                last[s, 0], last[s, 1], last[s, 2] = i, j, m
                _, num = find_or_add(slots, blocks, num, (int(i), int(j), int(m)))
    return len(points), num


@njit(cache=True, nogil=True, error_model="numpy")
def seen_mask(
    cubes: Keys, view: View, T_left_world: Array, side: float, behind: float
) -> NDArray[np.bool_]:
    """(K,) False if a view has no evidence for any point of a cube.

    Cubes (K, 3) are indexed along the axes; a view is informative up to `behind` its maximum depth.
    """
    found = np.empty(len(cubes), np.bool_)
    for k in range(len(cubes)):
        corner = _corner(cubes[k], T_left_world, side)
        found[k] = _is_in_sight(corner, T_left_world, view, side, behind)
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def fuse(blocks: Rows, view: View, T_left_world: Array, voxel: float) -> None:
    """Add the evidence of a view to every voxel of every visible block."""
    side = BLOCK * voxel
    for b in range(len(blocks)):
        corner = _corner(blocks[b].index, T_left_world, side)
        if _is_in_sight(corner, T_left_world, view, side, DEEPEST * voxel):
            _fuse_block(blocks[b], corner, T_left_world, view, voxel)


@njit(cache=True, nogil=True, error_model="numpy")
def _corner(index: Keys, T: Array, side: float) -> Place:
    """The corner of a cube in the view's frame."""
    x, y, z = index[0] * side, index[1] * side, index[2] * side
    return (
        T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3],
        T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3],
        T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _is_in_sight(corner: Place, T: Array, view: View, side: float, behind: float) -> bool:
    """False if a view has no evidence for any point of a cube, given by its corner."""
    half = 0.5 * side
    x = corner[0] + half * (T[0, 0] + T[0, 1] + T[0, 2])
    y = corner[1] + half * (T[1, 0] + T[1, 1] + T[1, 2])
    z = corner[2] + half * (T[2, 0] + T[2, 1] + T[2, 2])
    radius = np.sqrt(3.0) * half
    if z + radius <= 0 or z - radius > view.farthest + behind:
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
def _fuse_block(block: Any, corner: Place, T: Array, view: View, voxel: float) -> None:
    distance, weight = block.distance, block.weight
    for k in range(BLOCK**3):
        x, y, z = voxel * (k % BLOCK), voxel * (k // BLOCK % BLOCK), voxel * (k // BLOCK**2)
        place = (
            corner[0] + T[0, 0] * x + T[0, 1] * y + T[0, 2] * z,
            corner[1] + T[1, 0] * x + T[1, 1] * y + T[1, 2] * z,
            corner[2] + T[2, 0] * x + T[2, 1] * y + T[2, 2] * z,
        )
        ahead, trust = _say(place, view, voxel)
        if trust > 0 and weight[k] < _FULL:
            units = np.floor(UNITS * trust + 0.5)
            weight[k] += np.int32(units)
            distance[k] += np.int32(np.floor(units * ahead / TRUNCATION + 0.5))


@njit(cache=True, nogil=True, error_model="numpy")
def _say(place: Place, view: View, voxel: float) -> tuple[float, float]:
    """Distance in voxels of a point of the view's frame in front of the surface, and its weight.

    The weight is 0 if the view has no evidence for it.
    """
    if not place[2] > 0:
        return 0.0, 0.0
    focal, cx, cy = view.camera
    u, v = focal * place[0] / place[2] + cx, focal * place[1] / place[2] + cy
    height, width = view.depth.shape
    if not (0 <= u < width - 1 and 0 <= v < height - 1):
        return 0.0, 0.0
    column, row = int(u + 0.5), int(v + 0.5)
    spread = view.sigma[row, column] / voxel
    behind = max(_BEHIND, _SIGMAS_BEHIND * spread)
    # Four pixels differ by no more than a jump, otherwise only the nearest counts.
    if not (view.depth[row, column] - place[2]) / voxel >= -behind - _JUMP:
        return 0.0, 0.0
    ahead = (_depth_at(view.depth, u, v, _JUMP * voxel) - place[2]) / voxel
    if not ahead >= -behind:  # also if the depth is unknown
        return 0.0, 0.0
    trust = 1 / (spread * spread + 0.25)
    if ahead > TRUNCATION:
        trust *= _FREE_SHARE
    elif ahead < -_BEHIND:
        trust *= _BEHIND_SHARE
    return min(ahead, max(TRUNCATION, _SIGMAS_BEFORE * spread)), trust


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
