"""The depth of every pixel of a view, with its uncertainty."""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.camera import StereoRig
from recon.geometry import LEVEL_CAMERA
from recon.records import DisparityMap, StereoPair, as_rgb

Floats = NDArray[np.float32]
Array = NDArray[np.float64]
Camera = tuple[float, float, float]

_FARTHEST = 0.5
"""Maximum sigma of a depth, relative to the depth."""
_SIGMA_SCALE, _SIGMA_FLOOR_PX = 1.3, 0.08
"""Errors of neighbouring pixels are correlated, and calibration errors do not average out."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DepthMap:
    """The image of one left camera, with its depths."""

    depth: Floats
    """(H, W) along z of the left camera, world units; NaN = unknown."""
    sigma: Floats
    """(H, W) standard deviation of the depth."""
    colours: NDArray[np.uint8]
    """(H, W, 3) RGB."""
    rig: StereoRig
    T_world_left: Array
    """(4, 4)"""
    num_views: NDArray[np.uint8] | None = None
    """(H, W) agreeing views, including this one; None before confirmation."""

    @property
    def valid_mask(self) -> NDArray[np.bool_]:
        """(H, W) pixels whose depth is known."""
        return np.isfinite(self.depth)

    @property
    def position(self) -> Array:
        """(3,) of the left camera, world."""
        place: Array = self.T_world_left[:3, 3]
        return place

    @property
    def camera(self) -> Camera:
        """Focal length and principal point, pixels."""
        return self.rig.focal_px, self.rig.cx_left_px, self.rig.cy_px

    def points(self, mask: NDArray[np.bool_]) -> Array:
        """(N, 3) points of the pixels of `mask`, in the world, row by row."""
        pixels = np.argwhere(mask)
        points = np.empty((len(pixels), 3))
        _place(self.depth, pixels, self.camera, self.T_world_left, points)
        return points

    def where(self, kept_mask: NDArray[np.bool_]) -> "DepthMap":
        """The same depths, unknown outside `kept_mask` (H, W)."""
        return replace(self, depth=np.where(kept_mask, self.depth, np.float32(np.nan)))


def depth_map(pair: StereoPair, found: DisparityMap) -> DepthMap:
    """The depths of a pair's left pixels; a pair without a pose is level at the origin."""
    depth = pair.rig.depth(found.disparity_px)
    sigma_px = np.hypot(_SIGMA_SCALE * found.sigma_px, _SIGMA_FLOOR_PX)
    sigma = pair.rig.depth_sigma(depth, sigma_px)
    view = DepthMap(
        depth=depth.astype(np.float32),
        sigma=sigma.astype(np.float32),
        colours=as_rgb(pair.left),
        rig=pair.rig,
        T_world_left=LEVEL_CAMERA if pair.T_world_left is None else pair.T_world_left,
    )
    return view.where(sigma <= _FARTHEST * depth)


@njit(cache=True, nogil=True)
def _place(
    depth: Floats, pixels: NDArray[np.int64], camera: Camera, T: Array, points: Array
) -> None:
    """Write the points of pixels (row, column), moved by a transformation."""
    focal, cx, cy = camera
    for k in range(len(pixels)):
        v, u = pixels[k]
        z = np.float64(depth[v, u])
        x, y = (u - cx) / focal * z, (v - cy) / focal * z
        for axis in range(3):
            points[k, axis] = T[axis, 0] * x + T[axis, 1] * y + T[axis, 2] * z + T[axis, 3]
