"""Compiled loops: the texels of a map that a camera has in view."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

MARGIN_PX = 2.0
"""Pixels along the borders of an image that are not used."""
LEAST_COSINE = 0.25
"""Of the angle between the line of sight and the normal: at outlines colours are mixed."""
TILE_PX = 4.0
"""Side of the tiles in which the nearest texel hides those behind it."""


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


@njit(cache=True, nogil=True)
def _projected(points: Array, normals: Array, camera: Camera) -> tuple[NDArray[np.int64], Array]:
    """Rows (M,) in the image that face the camera, with u, v, pixels per length and cosine."""
    rows, seen, number = np.empty(len(points), np.int64), np.empty((len(points), 4)), 0
    turn, eye = camera.turn, camera.eye
    for k in range(len(points)):
        dx, dy, dz = points[k, 0] - eye[0], points[k, 1] - eye[1], points[k, 2] - eye[2]
        z = dx * turn[0, 2] + dy * turn[1, 2] + dz * turn[2, 2]
        facing = -(dx * normals[k, 0] + dy * normals[k, 1] + dz * normals[k, 2])
        if z <= 0.0 or facing <= 0.0:
            continue
        zoom = camera.focal_px / z
        u = camera.cx_px + zoom * (dx * turn[0, 0] + dy * turn[1, 0] + dz * turn[2, 0])
        v = camera.cy_px + zoom * (dx * turn[0, 1] + dy * turn[1, 1] + dz * turn[2, 1])
        inside = MARGIN_PX <= u < camera.width - MARGIN_PX
        if inside and MARGIN_PX <= v < camera.height - MARGIN_PX:
            cosine = facing / math.sqrt(dx * dx + dy * dy + dz * dz)
            rows[number], seen[number] = k, np.array([u, v, zoom, cosine])
            number += 1
    return rows[:number], seen[:number]


@njit(cache=True, nogil=True)
def _nearest(seen: Array, camera: Camera, reach: float) -> Array:
    """Greatest zoom (R, C) of the points around each tile."""
    lines, columns = int(camera.height / TILE_PX) + 1, int(camera.width / TILE_PX) + 1
    nearest = np.zeros((lines, columns))
    for i in range(len(seen)):
        u, v, zoom = seen[i, 0], seen[i, 1], seen[i, 2]
        half = reach * zoom
        top, bottom = max(int((v - half) / TILE_PX), 0), min(int((v + half) / TILE_PX), lines - 1)
        left, right = max(int((u - half) / TILE_PX), 0), min(int((u + half) / TILE_PX), columns - 1)
        for line in range(top, bottom + 1):
            for column in range(left, right + 1):
                nearest[line, column] = max(nearest[line, column], zoom)
    return nearest


@njit(cache=True, nogil=True)
def in_view(
    points: Array, normals: Array, camera: Camera, reach: float, slack: float
) -> tuple[NDArray[np.int64], Array]:
    """Rows (M,) of the points that a camera sees, and u, v, pixels per length and cosine (M, 4).

    Points hide what is farther by more than the slack within some reach around them.
    """
    rows, seen = _projected(points, normals, camera)
    nearest = _nearest(seen, camera, reach)
    kept = 0
    for i in range(len(rows)):
        zoom = nearest[int(seen[i, 1] / TILE_PX), int(seen[i, 0] / TILE_PX)]
        is_open = camera.focal_px / seen[i, 2] < camera.focal_px / zoom + slack
        if is_open and seen[i, 3] > LEAST_COSINE:
            rows[kept], seen[kept] = rows[i], seen[i]
            kept += 1
    return rows[:kept], seen[:kept]
