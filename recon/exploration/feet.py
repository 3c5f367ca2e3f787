"""Feet of obstacles in the image: plain ground is free up to the first edge on it.

Stereo cannot match obstacles without texture or horizontal edges. Their feet still stand out from
the ground in front of them, as for Horswill's Polly (1993). Textured ground raises the contrast
that an edge needs, until stereo alone decides.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from recon.exploration.floor import RAY_SPACING, Array, Floor, Mask
from recon.geometry import invert, transform
from recon.records import StereoPair

NEAR_SAMPLES, TEXTURED_SHARE = 8, 0.2
"""The ground is textured if more than this share of its nearest samples are edges."""
SMOOTHING_PX = 1.0
MIN_CONTRAST = 8.0
"""Minimum difference of grey levels across an edge ..."""
CONTRAST_RATIO = 4.0
"""... and minimum multiple of the median contrast of the ground, noise or texture."""
HORIZON_PX = 4.0
"""Rows below the end of the ground that are affected by its blurred edge."""


def foot_distances(
    pair: StereoPair, azimuths_rad: Array, place: Array, ground: tuple[float, float], floor: Floor
) -> Array:
    """Distance (A,) along each azimuth (A,) of the first edge on the ground; infinite = none.

    Parameters
    ----------
    place : (2,) float64
        x, z of the origin of the azimuths.
    ground : (float, float)
        Height of the ground, and distance at which it ends.
    """
    height, end = ground
    reach = _reach(pair, height, end)
    step = RAY_SPACING * floor.cell_size
    radii = step * np.arange(1, max(2, int(reach / step)))
    directions = np.column_stack([np.cos(azimuths_rad), np.sin(azimuths_rad)])
    x, z = np.moveaxis(place + directions[:, None] * radii[:, None], -1, 0)
    pixels, inside = _pixels(pair, np.stack([x, np.full_like(x, height), z], axis=-1))
    contrast = _contrast(pair.left)
    seen = contrast[pixels[..., 1], pixels[..., 0]]
    typical = float(np.median(seen[inside])) if inside.any() else 0.0
    is_edge = inside & (seen > max(MIN_CONTRAST, CONTRAST_RATIO * typical))
    if _is_textured(is_edge, inside):
        return np.full(len(azimuths_rad), np.inf)
    return np.where(is_edge.any(axis=1), radii[is_edge.argmax(axis=1)], np.inf)


def _is_textured(is_edge: Mask, inside: Mask) -> bool:
    """True if the ground directly in front of the camera is full of edges."""
    near = inside & (inside.cumsum(axis=1) <= NEAR_SAMPLES)
    return bool(near.any() and is_edge[near].mean() > TEXTURED_SHARE)


def _reach(pair: StereoPair, height: float, end: float) -> float:
    """Distance at which the ground is too close to its end in the image."""
    eye_height = 0.0 if pair.T_world_left is None else pair.T_world_left[1, 3] - height
    if eye_height <= 0.0:
        return 0.0
    return float(1.0 / (1.0 / end + HORIZON_PX / (pair.rig.focal_px * eye_height)))


def _pixels(pair: StereoPair, points_world: Array) -> tuple[NDArray[np.intp], Mask]:
    """Pixels (..., 2) of points (..., 3) in the left image, and a mask of those inside it."""
    T_left_world = invert(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
    points_left = transform(T_left_world, points_world.reshape(-1, 3))
    ahead = points_left[:, 2] > 0.0
    points_left[~ahead, 2] = 1.0
    pixels = np.rint(pair.rig.project_left(points_left)).astype(np.intp)
    size = np.array([pair.rig.width, pair.rig.height])
    inside = ahead & (pixels >= 0).all(axis=1) & (pixels < size).all(axis=1)
    shape = points_world.shape[:-1]
    return pixels.clip(0, size - 1).reshape(*shape, 2), inside.reshape(shape)


def _contrast(image: NDArray[np.uint8]) -> Array:
    """Largest difference (H, W) of a channel across a pixel, along its row or column."""
    contrast = np.zeros(image.shape[:2])
    for channel in np.moveaxis(image.reshape(*image.shape[:2], -1), -1, 0):
        smooth = gaussian_filter(channel.astype(np.float32), SMOOTHING_PX, mode="nearest")
        _add_rises(smooth, contrast)
    return contrast


@njit(cache=True)
def _add_rises(smooth: NDArray[np.float32], contrast: Array) -> None:
    """Raise `contrast` (H, W) to the differences across the pixels of an image (H, W)."""
    height, width = smooth.shape
    for y in range(height):
        above, below = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            before, after = max(x - 1, 0), min(x + 1, width - 1)
            down = abs(smooth[below, x] - smooth[above, x]) / (below - above) * 2.0
            right = abs(smooth[y, after] - smooth[y, before]) / (after - before) * 2.0
            contrast[y, x] = max(contrast[y, x], down, right)
