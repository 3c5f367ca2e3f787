"""Comparison of a pair with the view of a map from a pose, tile by tile of the image.

Texture repeats, and trees look alike; what is behind them and what is missing distinguishes places.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from recon.camera import StereoRig
from recon.geometry import invert, transform
from recon.records import PointCloud, Voxels

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NUM_TILES = 16
"""Number of tiles along the longer side of the image."""
MIN_POINTS = 2
"""Minimum number of points of a tile that shows something."""
DEPTH_RATIO = 1.25
"""Depths that differ by a smaller factor are equal ..."""
NUM_SIGMAS = 3.0
"""... and so are those that differ by fewer standard deviations of the points."""
MIN_DEPTH = 1e-3
NEW_WEIGHT = 0.5
"""Weight of a tile that shows something missing in the map: maps are seldom complete."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outlook:
    """The depth of a pair, tile by tile."""

    rig: StereoRig
    depth: Array
    """(R, C) depth; infinite if nothing is seen."""
    ratio: Array
    """(R, C) factor by which the depth may be off."""

    @classmethod
    def of(cls, cloud: PointCloud, rig: StereoRig) -> "Outlook":
        """The outlook of a pair's points (left frame)."""
        z = cloud.points[:, 2]
        sigma = np.zeros(len(z)) if cloud.sigma is None else cloud.sigma
        ratio = np.maximum(DEPTH_RATIO, 1.0 + NUM_SIGMAS * sigma / np.maximum(z, MIN_DEPTH))
        tile, inside = _tiles(cloud.points, rig)
        depth = _nearest(tile[inside], z[inside], rig, MIN_POINTS)
        loose = np.ones(depth.size)
        np.maximum.at(loose, tile[inside], ratio[inside])
        return cls(rig=rig, depth=depth, ratio=loose.reshape(depth.shape))

    def agreement(self, voxels: Voxels, T_world_left: Array) -> tuple[int, int]:
        """The number of tiles that agree with the map, and of those that do not."""
        points = transform(invert(T_world_left), voxels.means)
        tile, inside = _tiles(points, self.rig)
        shown = _nearest(tile[inside], points[inside, 2], self.rig, 1)
        is_seen, is_shown = np.isfinite(self.depth), np.isfinite(shown)
        near, far = _around(shown)
        as_seen = is_seen & (near <= self.depth * self.ratio) & (far >= self.depth / self.ratio)
        # A reliable point where the map has nothing; a cell that the pair looks through.
        is_new = is_seen & ~as_seen & (self.ratio < 2.0 * DEPTH_RATIO)
        _, behind = _around(self.depth, empty=np.inf)
        is_missing = is_shown & ~is_seen & (behind > DEPTH_RATIO * shown) & ~_touches(is_seen)
        return int(as_seen.sum()), int(NEW_WEIGHT * is_new.sum() + is_missing.sum())


def _grid(rig: StereoRig) -> tuple[float, int, int]:
    """Side of a tile in pixels, and the number of rows and columns."""
    side = max(rig.width, rig.height) / NUM_TILES
    return side, int(np.ceil(rig.height / side)), int(np.ceil(rig.width / side))


def _tiles(points_left: Array, rig: StereoRig) -> tuple[NDArray[np.intp], Mask]:
    """Tile index (N,) of each point, and a mask of the points in the image."""
    side, rows, columns = _grid(rig)
    ahead = points_left[:, 2] > MIN_DEPTH
    pixels = np.full((len(points_left), 2), -1.0)
    pixels[ahead] = rig.project_left(points_left[ahead])
    column, row = np.floor((pixels.clip(-1e6, 1e6) + 0.5) / side).astype(np.intp).T
    inside = ahead & (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return np.where(inside, row * columns + column, 0), inside


def _nearest(tile: NDArray[np.intp], depth: Array, rig: StereoRig, least: int) -> Array:
    """Depth (R, C) of the nearest point of each tile with enough points; otherwise infinite."""
    _, rows, columns = _grid(rig)
    nearest = np.full(rows * columns, np.inf)
    np.minimum.at(nearest, tile, depth)
    nearest[np.bincount(tile, minlength=rows * columns) < least] = np.inf
    return nearest.reshape(rows, columns)


def _around(depth: Array, empty: float = 0.0) -> tuple[Array, Array]:
    """The minimum and maximum depth of each tile and its neighbours."""
    near: Array = minimum_filter(depth, 3, mode="nearest")
    far: Array = maximum_filter(np.where(np.isfinite(depth), depth, empty), 3, mode="nearest")
    return near, far


def _touches(mask: Mask) -> Mask:
    touched: Mask = maximum_filter(mask, 3, mode="nearest")
    return touched
