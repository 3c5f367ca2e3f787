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
from recon.geometry import invert
from recon.records import StereoPair

NEAR_SAMPLES, TEXTURED_SHARE = 8, 0.2
"""The ground is textured if more than this share of its nearest samples are edges."""
SMOOTHING_PX, BORDER_PX = 1.0, 5
"""Blur before contrasts are measured, and number of rows away that can affect a contrast."""
OUTSIDE = -1
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
    size, projection = (pair.rig.width, pair.rig.height), _projection(pair)
    start = projection @ np.array([place[0], height, place[1], 1.0])
    pixel = _pixels(projection, start, azimuths_rad, radii, size)
    inside = pixel != OUTSIDE
    seen = np.where(inside, _contrast_at(pair.left, pixel), 0.0)
    typical = float(np.median(seen[inside])) if inside.any() else 0.0
    is_edge = seen > max(MIN_CONTRAST, CONTRAST_RATIO * typical)
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


def _projection(pair: StereoPair) -> Array:
    """(3, 4) projection of world points to the left image."""
    T_left_world = invert(np.eye(4) if pair.T_world_left is None else pair.T_world_left)
    projection: Array = pair.rig.K_left @ T_left_world[:3]
    return projection


@njit(cache=True)
def _pixels(
    projection: Array, start: Array, azimuths: Array, radii: Array, size: tuple[int, int]
) -> NDArray[np.int64]:
    """Flat index (A, R) of the pixel of each ground point around a `start`, or `OUTSIDE`.

    Parameters
    ----------
    projection, start : (3, 4), (3,)
        Projection of world points, and of the point in the middle.
    """
    pixel = np.full((len(azimuths), len(radii)), OUTSIDE)
    for a in range(len(azimuths)):
        rise = projection[:, 0] * np.cos(azimuths[a]) + projection[:, 2] * np.sin(azimuths[a])
        for r in range(len(radii)):
            pixel[a, r] = _pixel(start, rise, radii[r], size)
    return pixel


@njit(cache=True)
def _pixel(start: Array, rise: Array, radius: float, size: tuple[int, int]) -> int:
    """Flat index of the pixel of a homogeneous image point `start` + radius * `rise` (3,)."""
    depth = start[2] + radius * rise[2]
    if depth <= 0.0:
        return OUTSIDE
    u = np.rint((start[0] + radius * rise[0]) / depth)
    v = np.rint((start[1] + radius * rise[1]) / depth)
    return int(v) * size[0] + int(u) if 0 <= u < size[0] and 0 <= v < size[1] else OUTSIDE


def _contrast_at(image: NDArray[np.uint8], pixel: NDArray[np.int64]) -> Array:
    """Contrast (A, R) at the pixels with some flat indices (A, R); undefined `OUTSIDE`."""
    height, width = image.shape[:2]
    first = int(pixel[pixel != OUTSIDE].min(initial=height * width - 1)) // width
    top = max(0, first - BORDER_PX)
    contrast: Array = _contrast(image[top:]).ravel()[np.maximum(pixel - top * width, 0)]
    return contrast


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
