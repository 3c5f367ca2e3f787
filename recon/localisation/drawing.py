"""Compiled loops: solids of revolution as a camera sees them.

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
Box = tuple[int, int, int, int]
"""First and last row, first and last column."""


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


class Drawn(NamedTuple):
    """An image of solids: the solid and the depth at each pixel."""

    solid: Indices
    """(R, C) number of the solid at each pixel; -1 where there is none."""
    depth: Array
    """(R, C) along the axis of the camera; infinite where there is nothing."""


class Views(NamedTuple):
    """A camera as solids see it: in the frame of each."""

    eye: Array
    """(S, 3)"""
    turn: Array
    """(S, 3, 3) rotation from the camera."""


@njit(cache=True, nogil=True)
def _window(middle: float, half: float, size: int) -> tuple[int, int]:
    return max(0, math.floor(middle - half)), min(size - 1, math.ceil(middle + half))


@njit(cache=True, nogil=True)
def _is_aside(camera: Camera, centre: Array, reach: float) -> bool:
    """True if a ball is outside one of the sides of the field of view."""
    f, (x, y, z) = camera.focal_px, centre
    left, top = camera.cx_px + 1.0, camera.cy_px + 1.0
    right, bottom = camera.width - camera.cx_px, camera.height - camera.cy_px
    return bool(
        x * f + left * z < -reach * math.hypot(f, left)
        or -x * f + right * z < -reach * math.hypot(f, right)
        or y * f + top * z < -reach * math.hypot(f, top)
        or -y * f + bottom * z < -reach * math.hypot(f, bottom)
    )


@njit(cache=True, nogil=True)
def _ball(solids: Solids, s: int) -> tuple[Array, float]:
    """Centre and radius of a ball around a solid."""
    first, last = solids.ends[s]
    centre = solids.origin[s] + 0.5 * (first + last) * solids.frame[s, 2]
    widest_sq = solids.reach[s] ** 2 - max(abs(first), abs(last)) ** 2
    return centre, math.sqrt(max(widest_sq, 0.0) + 0.25 * (last - first) ** 2)


@njit(cache=True, nogil=True)
def _windows(
    centre: Array, reach: float, camera: Camera, block: int, shape: tuple[int, int]
) -> tuple[int, int, int, int]:
    """First and last row and column of the pixels that may show a ball."""
    x, y, z = centre
    if _is_aside(camera, centre, reach):
        return 0, -1, 0, -1
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


@njit(cache=True, nogil=True, inline="always")
def meeting(solids: Solids, views: Views, s: int, x: float, y: float) -> tuple[float, float]:
    """Depth at which a ray (x, y, 1) meets a solid first, and the place along its axis.

    The depth is infinite if it does not meet it.
    """
    m, eye, radius_sq = views.turn, views.eye, solids.radius_sq
    u = m[s, 0, 0] * x + m[s, 0, 1] * y + m[s, 0, 2]
    v = m[s, 1, 0] * x + m[s, 1, 1] * y + m[s, 1, 2]
    w = m[s, 2, 0] * x + m[s, 2, 1] * y + m[s, 2, 2]
    a = u * u + v * v - radius_sq[s, 2] * w * w
    half = 0.5 * radius_sq[s, 1] + radius_sq[s, 2] * eye[s, 2]
    b = eye[s, 0] * u + eye[s, 1] * v - half * w
    c = eye[s, 0] ** 2 + eye[s, 1] ** 2 - radius_sq[s, 0]
    c -= (half + 0.5 * radius_sq[s, 1]) * eye[s, 2]
    root = b * b - a * c
    if root >= 0.0 and abs(a) > 1e-12:
        root = math.sqrt(root) if a > 0.0 else -math.sqrt(root)
        for depth in ((-b - root) / a, (-b + root) / a):
            t = eye[s, 2] + depth * w
            if depth > 0.0 and solids.ends[s, 0] <= t <= solids.ends[s, 1]:
                return depth, t
    return math.inf, 0.0


@njit(cache=True, nogil=True, inline="always")
def _row(share: float, number: int) -> int:
    return min(int(share * number), number - 1)


@njit(cache=True, nogil=True)
def viewed(solids: Solids, camera: Camera) -> Views:
    """A camera in the frames of solids."""
    views = Views(np.empty((len(solids.origin), 3)), np.empty((len(solids.origin), 3, 3)))
    for s in range(len(solids.origin)):
        views.eye[s] = solids.frame[s] @ (camera.eye - solids.origin[s])
        views.turn[s] = solids.frame[s] @ camera.turn
    return views


@njit(cache=True, nogil=True, inline="always")
def place_on(
    solids: Solids, views: Views, s: int, ray: tuple[float, float], depth: float
) -> tuple[float, float, float]:
    """Place (x, y, t) in the frame of a solid where a ray (x, y, 1) is at a depth."""
    m, eye, (x, y) = views.turn, views.eye, ray
    return (
        eye[s, 0] + depth * (m[s, 0, 0] * x + m[s, 0, 1] * y + m[s, 0, 2]),
        eye[s, 1] + depth * (m[s, 1, 0] * x + m[s, 1, 1] * y + m[s, 1, 2]),
        eye[s, 2] + depth * (m[s, 2, 0] * x + m[s, 2, 1] * y + m[s, 2, 2]),
    )


@njit(cache=True, nogil=True, inline="always")
def shares(solids: Solids, s: int, place: tuple[float, float, float]) -> tuple[float, float]:
    """Shares of the way around a solid and along its axis."""
    turn = math.atan2(place[1], place[0]) / (2.0 * math.pi)
    first, last = solids.ends[s, 0], solids.ends[s, 1]
    return turn - math.floor(turn), (place[2] - first) / (last - first)


@njit(cache=True, nogil=True)
def _draw(solids: Solids, views: Views, s: int, camera: Camera, block: int, drawn: Drawn) -> Box:
    """Draw a solid where nothing nearer is, and say within what."""
    solid, depth, unit = drawn.solid, drawn.depth, 1.0 / camera.focal_px
    centre, reach = _ball(solids, s)
    ahead = np.ascontiguousarray(camera.turn.T) @ (centre - camera.eye)
    top, bottom, left, right = _windows(ahead, reach, camera, block, solid.shape)
    for row in range(top, bottom + 1):
        y = ((row + 0.5) * block - 0.5 - camera.cy_px) * unit
        for column in range(left, right + 1):
            x = ((column + 0.5) * block - 0.5 - camera.cx_px) * unit
            met = meeting(solids, views, s, x, y)
            if met[0] < depth[row, column]:
                depth[row, column], solid[row, column] = met[0], s
    return top, bottom, left, right


@njit(cache=True, nogil=True)
def blank(height: int, width: int) -> Drawn:
    """An image of nothing."""
    shape = (height, width)
    return Drawn(np.full(shape, -1), np.full(shape, np.inf))


@njit(cache=True, nogil=True)
def draw_on(drawn: Drawn, solids: Solids, camera: Camera, block: int) -> Box:
    """Draw the solids that a camera sees on an image; all of them are within the box."""
    height, width = drawn.solid.shape
    first_row, last_row, first_column, last_column = height, -1, width, -1
    views = viewed(solids, camera)
    for s in range(len(solids.origin)):
        top, bottom, left, right = _draw(solids, views, s, camera, block, drawn)
        if top <= bottom and left <= right:
            first_row, last_row = min(first_row, top), max(last_row, bottom)
            first_column, last_column = min(first_column, left), max(last_column, right)
    return first_row, last_row, first_column, last_column


@njit(cache=True, nogil=True)
def clear(drawn: Drawn, box: Box) -> None:
    """Leave nothing drawn in a box."""
    top, bottom, left, right = box
    drawn.solid[top : bottom + 1, left : right + 1] = -1
    drawn.depth[top : bottom + 1, left : right + 1] = np.inf


@njit(cache=True, nogil=True)
def draw(solids: Solids, camera: Camera, block: int) -> Drawn:
    """Draw the solids that a camera sees, with a pixel for each `block` x `block` of its own."""
    drawn: Drawn = blank(camera.height // block, camera.width // block)
    draw_on(drawn, solids, camera, block)
    return drawn


@njit(cache=True, nogil=True, inline="always")
def direction(camera: Camera, block: float, row: int, column: int) -> tuple[float, float]:
    """Ray (x, y, 1) through the middle of a block of pixels."""
    x = ((column + 0.5) * block - 0.5 - camera.cx_px) / camera.focal_px
    return x, ((row + 0.5) * block - 0.5 - camera.cy_px) / camera.focal_px


@njit(cache=True, nogil=True)
def texels(solids: Solids, drawn: Drawn, camera: Camera) -> Indices:
    """Number of the texel at each pixel of an image; -1 where there is none."""
    number: Indices = np.full(drawn.solid.shape, -1)
    views, block = viewed(solids, camera), camera.height / drawn.solid.shape[0]
    of = solids.shape[:, 0] * solids.shape[:, 1]
    start = np.cumsum(of) - of
    for row in range(number.shape[0]):
        for column in range(number.shape[1]):
            s = drawn.solid[row, column]
            if s >= 0:
                ray = direction(camera, block, row, column)
                at = place_on(solids, views, s, ray, drawn.depth[row, column])
                around, along = shares(solids, s, at)
                first = start[s] + _row(around, solids.shape[s, 0]) * solids.shape[s, 1]
                number[row, column] = first + _row(along, solids.shape[s, 1])
    return number


@njit(cache=True, nogil=True)
def is_inside(solids: Solids, place: Array) -> bool:
    """True if a place is within a solid."""
    for s in range(len(solids.origin)):
        x, y, t = solids.frame[s] @ (place - solids.origin[s])
        k0, k1, k2 = solids.radius_sq[s]
        if solids.ends[s, 0] < t < solids.ends[s, 1] and x * x + y * y < k0 + k1 * t + k2 * t * t:
            return True
    return False
