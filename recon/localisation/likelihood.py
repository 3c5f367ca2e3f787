"""Compiled loops: how likely an image is if a camera sees painted solids before a backdrop."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.localisation.drawing import (
    Box,
    Camera,
    Drawn,
    Solids,
    Views,
    blank,
    clear,
    direction,
    draw_on,
    is_inside,
    meeting,
    viewed,
)
from recon.localisation.paint import Paint, painted

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

OUTLIERS = 0.1
"""Share of pixels that may have any colour."""
UNSEEN = -1.0
"""Colour of pixels that do not count."""
LEVELS = 16
"""Levels of each colour channel in the histogram of a backdrop."""
BAND, NUM_BANDS = 0.015, 60
"""Sine of the elevation that a band of directions covers, and the number of bands."""
LOG_ANY = -3.0 * math.log(256.0)
LOG_KNOWN = math.log(1.0 - OUTLIERS) - 1.5 * math.log(2.0 * math.pi) - LOG_ANY
LOG_OUTLIER = math.log(OUTLIERS)
NUM_RAYS, RAY_ROWS = 8, (3.0, 6.0, 0.0, 5.0, 2.0, 7.0, 1.0, 4.0)
"""Rays through a pixel at an outline, one in each of so many columns of it, and their rows."""
SAME_TILT = 1e-9
"""Difference of tilts, radians, between which no backdrop changes."""
HOPED = 7.2
"""Log density, less that of any colour, of the colours on a known side, about."""


@njit(cache=True, nogil=True)
def _band(rise: float, x: float, y: float) -> int:
    sine = rise / math.sqrt(1.0 + x * x + y * y)
    return min(max(math.floor(sine / BAND) + NUM_BANDS // 2, 0), NUM_BANDS - 1)


@njit(cache=True, nogil=True)
def bands(rise: Array, x: Array, y: Array) -> Indices:
    """Numbers (N,) of the bands of elevation of rays (x, y, 1) that rise so much (N,)."""
    found = np.empty(len(rise), np.int64)
    for n in range(len(rise)):
        found[n] = _band(rise[n], x[n], y[n])
    return found


@njit(cache=True, nogil=True, inline="always")
def _log_density(off_sq: float, sigma: float) -> float:
    """Log density of a colour so far from that of a texel, less that of any colour."""
    own = LOG_KNOWN - 0.5 * off_sq / (sigma * sigma) - 3.0 * math.log(sigma)
    return max(own, LOG_OUTLIER) + math.log1p(math.exp(-abs(own - LOG_OUTLIER)))


@njit(cache=True, nogil=True, inline="always")
def _is_outline(solid: Indices, row: int, column: int) -> bool:
    """True if a pixel beside one shows another solid, or nothing."""
    here = solid[row, column]
    return bool(
        (row > 0 and solid[row - 1, column] != here)
        or (column > 0 and solid[row, column - 1] != here)
        or (row + 1 < solid.shape[0] and solid[row + 1, column] != here)
        or (column + 1 < solid.shape[1] and solid[row, column + 1] != here)
    )


@njit(cache=True, nogil=True)
def _around(solid: Indices, row: int, column: int, found: Indices) -> int:
    """Write the numbers of the solids at a pixel and those around it; returns how many."""
    number = 0
    for r in range(max(row - 1, 0), min(row + 2, solid.shape[0])):
        for c in range(max(column - 1, 0), min(column + 2, solid.shape[1])):
            s, is_new = solid[r, c], solid[r, c] >= 0
            for n in range(number):
                is_new &= found[n] != s
            if is_new:
                found[number] = s
                number += 1
    return number


@njit(cache=True, nogil=True, inline="always")
def _add(colour: Array, of: Array, row: int) -> None:
    for channel in range(3):
        colour[channel] += of[row, channel]


@njit(cache=True, nogil=True)
def _mixed(
    solids: Solids,
    views: Views,
    near: tuple[Indices, int],
    paint: Paint,
    ray: tuple[float, float, float],
    band: int,
    colour: Array,
) -> float:
    """Mean colour, written to `colour`, and its standard deviation, of a pixel at an outline.

    The ray is the first one through the pixel, and `ray[2]` the side of the pixel.
    """
    sigma = 0.0
    colour[:] = 0.0
    for n in range(NUM_RAYS):
        x = ray[0] + ray[2] * n / NUM_RAYS
        y = ray[1] + ray[2] * RAY_ROWS[n] / NUM_RAYS
        first, seen = (math.inf, 0.0), -1
        for number in range(near[1]):
            met = meeting(solids, views, near[0][number], x, y)
            if met[0] < first[0]:
                first, seen = met, near[0][number]
        if seen < 0:
            _add(colour, paint.behind, band)
            sigma += paint.behind_sigma[band]
            continue
        here = painted(solids, views, seen, paint, (x, y, ray[2]), first[0], colour)
        if here <= 0.0:
            return 0.0
        sigma += here
    colour /= NUM_RAYS
    return sigma / NUM_RAYS


@njit(cache=True, nogil=True, inline="always")
def _band_at(camera: Camera, x: float, y: float) -> int:
    rise = camera.turn[1, 0] * x + camera.turn[1, 1] * y + camera.turn[1, 2]
    band: int = _band(rise, x, y)
    return band


@njit(cache=True, nogil=True)
def _empty(image: Array, paint: Paint, camera: Camera) -> Array:
    """Log density (R, C) of the pixels of an image, less that of any colour, of the backdrop."""
    here, block = np.empty(image.shape[:2]), camera.height / image.shape[0]
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            x, y = direction(camera, block, row, column)
            r, g, b = image[row, column, 0], image[row, column, 1], image[row, column, 2]
            band = _band_at(camera, x, y)
            if r == UNSEEN:
                here[row, column] = 0.0
                continue
            likely = paint.backdrop[band, int(r) >> 4, int(g) >> 4, int(b) >> 4]
            here[row, column] = likely - LOG_ANY
    return here


@njit(cache=True, nogil=True)
def _fill(
    image: Array, solids: Solids, drawn: Drawn, paint: Paint, camera: Camera, box: Box, here: Array
) -> float:
    """Write log densities (R, C) where something is drawn; returns how much they gain.

    They are those of texels, and at outlines that of the mean of what a pixel shows.
    """
    block, gain = camera.height / image.shape[0], 0.0
    side = block / camera.focal_px
    views, mixed, around = viewed(solids, camera), np.empty(3), np.empty(9, np.int64)
    for row in range(max(box[0] - 1, 0), min(box[1] + 2, image.shape[0])):
        for column in range(max(box[2] - 1, 0), min(box[3] + 2, image.shape[1])):
            s, is_outline = drawn.solid[row, column], _is_outline(drawn.solid, row, column)
            if (s < 0 and not is_outline) or image[row, column, 0] == UNSEEN:
                continue
            x, y = direction(camera, block, row, column)
            if is_outline:
                # Rays of a pixel start at ever other places, or upright outlines would jump.
                first = ((0.618034 * (row + column)) % 1.0 / NUM_RAYS - 0.5) * side
                near = (around, _around(drawn.solid, row, column, around))
                band, ray = _band_at(camera, x, y), (x + first, y + first, side)
                spread = _mixed(solids, views, near, paint, ray, band, mixed)
            else:
                mixed[:] = 0.0
                depth = drawn.depth[row, column]
                spread = painted(solids, views, s, paint, (x, y, side), depth, mixed)
            value = HOPED
            if spread > 0.0:
                off = (image[row, column, 0] - mixed[0]) ** 2
                off += (image[row, column, 1] - mixed[1]) ** 2
                off += (image[row, column, 2] - mixed[2]) ** 2
                value = _log_density(off, spread)
            gain += value - here[row, column]
            here[row, column] = value
    return gain


@njit(cache=True, nogil=True)
def densities(image: Array, solids: Solids, drawn: Drawn, paint: Paint, camera: Camera) -> Array:
    """Log density (R, C) of each pixel of an image (R, C, 3), less that of any colour."""
    here: Array = _empty(image, paint, camera)
    _fill(image, solids, drawn, paint, camera, (0, here.shape[0] - 1, 0, here.shape[1] - 1), here)
    return here


@njit(cache=True, nogil=True)
def values(image: Array, solids: Solids, paint: Paint, camera: Camera, poses: Array) -> Array:
    """Log likelihoods (N,) of an image if taken at poses (N, 4, 4); none inside a solid."""
    found, block = np.full(len(poses), -np.inf), camera.height // image.shape[0]
    drawn, up = blank(image.shape[0], image.shape[1]), np.zeros(3)
    empty, before = np.empty(image.shape[:2]), 0.0
    here = empty.copy()
    for n in range(len(poses)):
        turn = np.ascontiguousarray(poses[n, :3, :3])
        eye = np.ascontiguousarray(poses[n, :3, 3])
        if is_inside(solids, eye):
            continue
        there = Camera(
            turn, eye, camera.focal_px, camera.cx_px, camera.cy_px, camera.width, camera.height
        )
        if np.abs(turn[1] - up).max() > SAME_TILT:
            empty, up = _empty(image, paint, there), turn[1].copy()
            before, here = empty.sum(), empty.copy()
        box = draw_on(drawn, solids, there, block)
        found[n] = before + _fill(image, solids, drawn, paint, there, box, here)
        clear(drawn, box)
        rows, columns = slice(max(box[0] - 1, 0), box[1] + 2), slice(max(box[2] - 1, 0), box[3] + 2)
        here[rows, columns] = empty[rows, columns]
    return found
