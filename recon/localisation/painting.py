"""Painting: the colours that images show on the texels of solids."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.drawing import Camera, Drawn, Indices, Solids, Views, viewed

LEAST_COSINE = 0.2
"""Of the angle between the line of sight and the normal: at outlines colours are mixed."""
MARGIN_PX = 2
BESIDE = 0.25
"""Width of a texel beside an outline, where colours are mixed, as a share of that elsewhere."""
BLURS_PX = (1, 3, 5, 9)
"""Widths of the means that a texel's colour is read from, as wide as the texel."""


class Texels(NamedTuple):
    """The finest texels of solids, by azimuth and place along the axis."""

    grid: Indices
    """(S, 2) numbers around and along."""
    first: Indices
    """(S,) first one of each solid."""
    width: Array
    """(K,) in pixels, of the image that shows each best; 0 if none does."""
    colour: NDArray[np.float32]
    """(K, 3) RGB."""

    @classmethod
    def blank(cls, grid: Indices) -> "Texels":
        """Texels that no image has shown."""
        number = grid.prod(axis=1)
        total = int(number.sum())
        colour = np.zeros((total, 3), np.float32)
        return cls(grid, np.cumsum(number) - number, np.zeros(total), colour)

    def of(self, s: int) -> tuple[Array, Array]:
        """Widths (A, B) and colours (A, B, 3) of a solid."""
        around, along = (int(number) for number in self.grid[s])
        rows = slice(int(self.first[s]), int(self.first[s]) + around * along)
        colour = self.colour[rows].astype(np.float64).reshape(around, along, 3)
        return self.width[rows].reshape(around, along), colour

    def show(self, image: NDArray[np.uint8], solids: Solids, drawn: Drawn, camera: Camera) -> None:
        """Take the colours of an image where it shows texels better than those before."""
        blurred = np.stack([cv2.blur(image, (px, px)) for px in BLURS_PX])
        _show(self, blurred, solids, viewed(solids, camera), drawn, camera)


@njit(cache=True, nogil=True)
def _is_beside(solid: Indices, row: int, column: int) -> bool:
    for r in range(row - 1, row + 2):
        for c in range(column - 1, column + 2):
            if solid[r, c] != solid[row, column]:
                return True
    return False


@njit(cache=True, nogil=True)
def _read(images: NDArray[np.uint8], width: float, u: float, v: float, colour: Array) -> None:
    """Write the colour at a point, the mean over about so many pixels."""
    n = 0
    while n + 1 < len(BLURS_PX) and width * width > BLURS_PX[n] * BLURS_PX[n + 1]:
        n += 1
    left, top = int(u), int(v)
    x, y = u - left, v - top
    for channel in range(3):
        above = (1.0 - x) * images[n, top, left, channel] + x * images[n, top, left + 1, channel]
        below = (1.0 - x) * images[n, top + 1, left, channel]
        below += x * images[n, top + 1, left + 1, channel]
        colour[channel] = (1.0 - y) * above + y * below


@njit(cache=True, nogil=True)
def _show(
    texels: Texels,
    images: NDArray[np.uint8],
    solids: Solids,
    views: Views,
    drawn: Drawn,
    camera: Camera,
) -> None:
    for s in range(len(solids.origin)):
        turn = 2.0 * math.pi / texels.grid[s, 0] * (np.arange(texels.grid[s, 0]) + 0.5)
        ways = np.stack((np.cos(turn), np.sin(turn)))
        for b in range(texels.grid[s, 1]):
            _show_ring(texels, (s, b), ways, images, solids, views, (drawn.solid, camera))


@njit(cache=True, nogil=True)
def _show_ring(
    texels: Texels,
    ring: tuple[int, int],
    ways: Array,
    images: NDArray[np.uint8],
    solids: Solids,
    views: Views,
    there: tuple[Indices, Camera],
) -> None:
    """Show the texels of a solid at one place along its axis, in all directions (2, A)."""
    s, b = ring
    around, along = texels.grid[s, 0], texels.grid[s, 1]
    first, length = solids.ends[s, 0], solids.ends[s, 1] - solids.ends[s, 0]
    k0, k1, k2 = solids.radius_sq[s]
    x, y, h = views.eye[s]
    t = first + (b + 0.5) / along * length
    radius = math.sqrt(max(k0 + k1 * t + k2 * t * t, 1e-12))
    rise = 0.5 * k1 + k2 * t
    slant = math.sqrt(radius * radius + rise * rise)
    side = math.sqrt(2.0 * math.pi * slant * length / (around * along))
    # The way from the surface to the eye along a normal that is as long as `slant`.
    least = radius * radius + rise * (h - t)
    for a in range(around):
        facing = radius * (x * ways[0, a] + y * ways[1, a]) - least
        if facing > 0.0:
            place = (radius * ways[0, a], radius * ways[1, a], t)
            of = (s, texels.first[s] + a * along + b, place, facing / slant, side)
            _show_texel(texels, of, images, views, there[0], there[1])


@njit(cache=True, nogil=True)
def _show_texel(
    texels: Texels,
    of: tuple[int, int, tuple[float, float, float], float, float],
    images: NDArray[np.uint8],
    views: Views,
    solid: Indices,
    camera: Camera,
) -> None:
    """Show a texel: its solid, row, place, height of the eye above its plane, and side."""
    s, k, place, above, side = of
    eye, m = views.eye, views.turn
    x, y, t = place[0] - eye[s, 0], place[1] - eye[s, 1], place[2] - eye[s, 2]
    depth = m[s, 0, 2] * x + m[s, 1, 2] * y + m[s, 2, 2] * t
    cosine = above / math.sqrt(x * x + y * y + t * t)
    if cosine <= LEAST_COSINE or depth <= 0.0:
        return
    zoom = camera.focal_px / depth
    width = zoom * cosine * side
    if width <= texels.width[k]:
        return
    u = camera.cx_px + zoom * (m[s, 0, 0] * x + m[s, 1, 0] * y + m[s, 2, 0] * t)
    v = camera.cy_px + zoom * (m[s, 0, 1] * x + m[s, 1, 1] * y + m[s, 2, 1] * t)
    if not (
        MARGIN_PX <= u < camera.width - 1 - MARGIN_PX
        and MARGIN_PX <= v < camera.height - 1 - MARGIN_PX
    ):
        return
    row, column = int(v + 0.5), int(u + 0.5)
    if solid[row, column] != s:
        return
    if _is_beside(solid, row, column):
        width *= BESIDE
    if width > texels.width[k]:
        texels.width[k] = width
        _read(images, zoom * side, u, v, texels.colour[k])
