"""Compiled loops: solids of revolution as a camera sees them, and how well an image agrees.

Every sphere, ellipsoid, cylinder and cone is a surface whose squared radius is a polynomial of the
place along its axis; a ray meets it where a quadratic equation says.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

OUTLIERS = 0.1
"""Share of pixels that may have any colour."""
LEVELS = 16
"""Levels of each colour channel in the histogram of a backdrop."""
BAND, NUM_BANDS = 0.015, 60
"""Sine of the elevation that a band of directions covers, and the number of bands."""
LOG_ANY = -3.0 * math.log(256.0)
LOG_KNOWN = math.log(1.0 - OUTLIERS) - 1.5 * math.log(2.0 * math.pi) - LOG_ANY
LOG_OUTLIER = math.log(OUTLIERS)
HOPED = 4.0
"""Log density, less that of any colour, of the colours on a known side, about."""


class Camera(NamedTuple):
    """A left camera and its pose."""

    turn: Array
    """(3, 3) rotation from the camera to the world."""
    eye: Array
    """(3,)"""
    focal_px: float
    cx_px: float
    cy_px: float
    width: int
    height: int


class Solids(NamedTuple):
    """Solids of revolution, each with a grid of texels by azimuth and place along its axis."""

    origin: Array
    """(S, 3)"""
    frame: Array
    """(S, 3, 3) rows: two across the axis, and the axis."""
    radius_sq: Array
    """(S, 3) coefficients of 1, t and t^2 of the squared radius at t along the axis."""
    ends: Array
    """(S, 2) first and last t."""
    reach: Array
    """(S,) radius of a sphere around the origin that holds the solid."""
    shape: Indices
    """(S, 2) numbers of azimuths and of places along the axis."""
    start: Indices
    """(S,) first texel."""


class Drawn(NamedTuple):
    """An image of solids: the texel and the depth at each pixel."""

    texel: Indices
    """(R, C) number of the texel at each pixel; -1 where there is none."""
    depth: Array
    """(R, C) along the axis of the camera; infinite where there is nothing."""


class Paint(NamedTuple):
    """Colours of texels, and of what is behind them."""

    mean: Array
    """(K, 3) RGB."""
    sigma: Array
    """(K,) standard deviation of each channel; 0 for texels that may be just as seen."""
    backdrop: Array
    """(B, L, L, L) log density of the colours in each band of elevations."""


@njit(cache=True, nogil=True)
def _window(middle: float, half: float, size: int) -> tuple[int, int]:
    return max(0, math.floor(middle - half)), min(size - 1, math.ceil(middle + half))


@njit(cache=True, nogil=True)
def _windows(
    centre: Array, reach: float, camera: Camera, block: int, shape: tuple[int, int]
) -> tuple[int, int, int, int]:
    """First and last row and column of the pixels that may show a ball."""
    x, y, z = centre
    if z < 1.2 * reach:
        return (0, shape[0] - 1, 0, shape[1] - 1) if z > -reach else (0, -1, 0, -1)
    zoom, share = camera.focal_px / block, reach / (z - reach)
    column = (camera.cx_px + camera.focal_px * x / z + 0.5) / block
    row = (camera.cy_px + camera.focal_px * y / z + 0.5) / block
    wide = zoom * share * math.sqrt(1.0 + (x / z) ** 2) + 1.0
    tall = zoom * share * math.sqrt(1.0 + (y / z) ** 2) + 1.0
    top, bottom = _window(row, tall, shape[0])
    left, right = _window(column, wide, shape[1])
    return top, bottom, left, right


@njit(cache=True, nogil=True)
def _meeting(
    eye: tuple[float, float, float], ray: tuple[float, float, float], radius_sq: Array, ends: Array
) -> tuple[float, float]:
    """Depth at which a ray meets a solid first, and the place along its axis; infinite if not."""
    a = ray[0] * ray[0] + ray[1] * ray[1] - radius_sq[2] * ray[2] * ray[2]
    half = 0.5 * radius_sq[1] + radius_sq[2] * eye[2]
    b = eye[0] * ray[0] + eye[1] * ray[1] - half * ray[2]
    c = eye[0] * eye[0] + eye[1] * eye[1] - radius_sq[0] - (half + 0.5 * radius_sq[1]) * eye[2]
    root = b * b - a * c
    if root >= 0.0 and abs(a) > 1e-12:
        root = math.sqrt(root) if a > 0.0 else -math.sqrt(root)
        for depth in ((-b - root) / a, (-b + root) / a):
            t = eye[2] + depth * ray[2]
            if depth > 0.0 and ends[0] <= t <= ends[1]:
                return depth, t
    return math.inf, 0.0


@njit(cache=True, nogil=True)
def _row(share: float, number: int) -> int:
    return min(int(share * number), number - 1)


@njit(cache=True, nogil=True)
def _draw(solids: Solids, s: int, camera: Camera, block: int, drawn: Drawn) -> None:
    """Draw a solid where nothing nearer is."""
    texel, depth, unit = drawn.texel, drawn.depth, 1.0 / camera.focal_px
    offset = solids.origin[s] - camera.eye
    ahead = np.ascontiguousarray(camera.turn.T) @ offset
    top, bottom, left, right = _windows(ahead, solids.reach[s], camera, block, texel.shape)
    there, m = -(solids.frame[s] @ offset), solids.frame[s] @ camera.turn
    eye, radius_sq, ends = (there[0], there[1], there[2]), solids.radius_sq[s], solids.ends[s]
    around, along = solids.shape[s]
    start, per_length = solids.start[s], 1.0 / (ends[1] - ends[0])
    for row in range(top, bottom + 1):
        y = ((row + 0.5) * block - 0.5 - camera.cy_px) * unit
        for column in range(left, right + 1):
            x = ((column + 0.5) * block - 0.5 - camera.cx_px) * unit
            ray = (
                m[0, 0] * x + m[0, 1] * y + m[0, 2],
                m[1, 0] * x + m[1, 1] * y + m[1, 2],
                m[2, 0] * x + m[2, 1] * y + m[2, 2],
            )
            here, t = _meeting(eye, ray, radius_sq, ends)
            if here < depth[row, column]:
                turn = math.atan2(eye[1] + here * ray[1], eye[0] + here * ray[0]) / (2.0 * math.pi)
                depth[row, column] = here
                number = _row(turn - math.floor(turn), around) * along
                texel[row, column] = start + number + _row((t - ends[0]) * per_length, along)


@njit(cache=True, nogil=True)
def draw(solids: Solids, camera: Camera, block: int) -> Drawn:
    """Draw the solids that a camera sees, with a pixel for each `block` x `block` of its own."""
    shape = (camera.height // block, camera.width // block)
    drawn = Drawn(np.full(shape, -1), np.full(shape, np.inf))
    for s in range(len(solids.origin)):
        _draw(solids, s, camera, block, drawn)
    return drawn


@njit(cache=True, nogil=True)
def is_inside(solids: Solids, place: Array) -> bool:
    """True if a place is within a solid."""
    for s in range(len(solids.origin)):
        x, y, t = solids.frame[s] @ (place - solids.origin[s])
        k0, k1, k2 = solids.radius_sq[s]
        if solids.ends[s, 0] < t < solids.ends[s, 1] and x * x + y * y < k0 + k1 * t + k2 * t * t:
            return True
    return False


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


@njit(cache=True, nogil=True)
def _log_density(off_sq: float, sigma: float) -> float:
    """Log density of a colour so far from that of a texel, less that of any colour."""
    own = LOG_KNOWN - 0.5 * off_sq / (sigma * sigma) - 3.0 * math.log(sigma)
    return max(own, LOG_OUTLIER) + math.log1p(math.exp(-abs(own - LOG_OUTLIER)))


@njit(cache=True, nogil=True)
def agreement(image: Array, drawn: Drawn, paint: Paint, camera: Camera) -> tuple[float, int, int]:
    """Log likelihood of an image (R, C, 3), less that of any colours.

    It is that of the texels where something is drawn, and of the backdrop elsewhere. Also the
    number of pixels that show something, and of those that are explained.
    """
    value, num_shown, num_explained = 0.0, 0, 0
    texel, mean, sigma, backdrop = drawn.texel, paint.mean, paint.sigma, paint.backdrop
    block, unit = camera.height / image.shape[0], 1.0 / camera.focal_px
    up = (camera.turn[1, 0], camera.turn[1, 1], camera.turn[1, 2])
    for row in range(image.shape[0]):
        y = ((row + 0.5) * block - 0.5 - camera.cy_px) * unit
        for column in range(image.shape[1]):
            r, g, b = image[row, column, 0], image[row, column, 1], image[row, column, 2]
            k = texel[row, column]
            if k >= 0:
                off_sq = (r - mean[k, 0]) ** 2 + (g - mean[k, 1]) ** 2 + (b - mean[k, 2]) ** 2
                here = _log_density(off_sq, sigma[k]) if sigma[k] > 0.0 else HOPED
            else:
                x = ((column + 0.5) * block - 0.5 - camera.cx_px) * unit
                height = _band(up[0] * x + up[1] * y + up[2], x, y)
                here = backdrop[height, int(r) >> 4, int(g) >> 4, int(b) >> 4] - LOG_ANY
            value += here
            if k >= 0 or here < 0.0:
                num_shown += 1
                num_explained += here > 0.0
    return value, num_shown, num_explained


@njit(cache=True, nogil=True)
def values(image: Array, solids: Solids, paint: Paint, camera: Camera, poses: Array) -> Array:
    """Log likelihoods (N,) of an image if taken at poses (N, 4, 4); none inside a solid."""
    found, block = np.full(len(poses), -np.inf), camera.height // image.shape[0]
    for n in range(len(poses)):
        turn = np.ascontiguousarray(poses[n, :3, :3])
        eye = np.ascontiguousarray(poses[n, :3, 3])
        if not is_inside(solids, eye):
            there = Camera(
                turn, eye, camera.focal_px, camera.cx_px, camera.cy_px, camera.width, camera.height
            )
            found[n] = agreement(image, draw(solids, there, block), paint, there)[0]
    return found
