"""The compiled loops: the rays of image points, and the colours of their hits."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.geometry import Array

Vec = tuple[float, float, float]
Surface = tuple[Array, NDArray[np.int32]]
"""Facets (T, 26): a corner, the normal, then u v r g b at that corner, then the gradient (x, y, z)
of each of those five; and the texture (T,) of each facet, -1 = none."""
Atlas = tuple[NDArray[np.uint8], NDArray[np.int64], NDArray[np.int64]]
"""Texels, start and shape of a `TextureAtlas`."""
Backdrop = tuple[Array, Array, float]
"""Red, green, blue of the sky at the horizon and overhead, and the density of the fog."""


@njit(cache=True, nogil=True)
def cast_rays(frame: Array, points_px: Array, near: float) -> NDArray[np.float32]:
    """Rays (N, 6) of image points (N, 2), starting at the near plane; `frame` is a `Camera`'s."""
    rays = np.empty((len(points_px), 6), np.float32)
    for n in range(len(points_px)):
        origin, direction = _ray(frame, points_px[n, 0], points_px[n, 1])
        for k in range(3):
            rays[n, k] = origin[k] + near * direction[k]
            rays[n, 3 + k] = direction[k]
    return rays


@njit(cache=True, nogil=True)
def shade(
    frame: Array,
    points_px: Array,
    step_px: float,
    triangle: NDArray[np.int32],
    surface: Surface,
    atlas: Atlas,
    backdrop: Backdrop,
) -> tuple[Array, Array]:
    """Depths (N,) and colours (N, 3), 0 to 255, of image points (N, 2).

    Parameters
    ----------
    frame : (6, 3) float64
        Of a `Camera`.
    points_px : (N, 2) float64
    step_px : float
        Distance of the points in the image, which is the side of a point's footprint.
    triangle : (N,) int32
        The facet that each point's ray hits, -1 = none; its depth is NaN.
    """
    facets, texture = surface
    depth, colour = np.empty(len(points_px)), np.empty((len(points_px), 3))
    for n in range(len(points_px)):
        origin, direction = _ray(frame, points_px[n, 0], points_px[n, 1])
        rgb = sky = _sky(backdrop, direction)
        depth[n] = np.nan
        facet = triangle[n]
        if facet >= 0:
            depth[n], hit = _hit(facets, facet, origin, direction)
            rgb = (255.0, 255.0, 255.0)
            if texture[facet] >= 0:
                area = _footprint(frame, direction, depth[n], facets, facet) * step_px * step_px
                u, v = _value(facets, facet, 0, hit), _value(facets, facet, 1, hit)
                rgb = _texel(u, v, area, texture[facet], atlas)
            rgb = _tinted(rgb, facets, facet, hit)
            clear = np.exp(-backdrop[2] * depth[n])
            rgb = _add(_scaled(rgb, clear), _scaled(sky, 1.0 - clear))
        colour[n, 0], colour[n, 1], colour[n, 2] = rgb
    return depth, colour


@njit(cache=True, nogil=True)
def _hit(facets: Array, facet: int, origin: Vec, direction: Vec) -> tuple[float, Vec]:
    """Depth of a facet's plane along a ray, and the hit point relative to the facet's corner."""
    normal, offset = _row(facets, facet, 3), _sub(_row(facets, facet, 0), origin)
    depth: float = _dot(normal, offset) / _dot(normal, direction)
    return depth, _sub(_scaled(direction, depth), offset)


@njit(cache=True, nogil=True)
def _tinted(rgb: Vec, facets: Array, facet: int, hit: Vec) -> Vec:
    """A colour times the surface's own at a hit point relative to the facet's corner."""
    return (
        rgb[0] * _value(facets, facet, 2, hit),
        rgb[1] * _value(facets, facet, 3, hit),
        rgb[2] * _value(facets, facet, 4, hit),
    )


@njit(cache=True, nogil=True)
def skies(frame: Array, points_px: Array, backdrop: Backdrop) -> Array:
    """Colours (N, 3) of the sky behind image points (N, 2)."""
    colour = np.empty((len(points_px), 3))
    for n in range(len(points_px)):
        _, direction = _ray(frame, points_px[n, 0], points_px[n, 1])
        colour[n, 0], colour[n, 1], colour[n, 2] = _sky(backdrop, direction)
    return colour


@njit(cache=True, nogil=True)
def _ray(frame: Array, u: float, v: float) -> tuple[Vec, Vec]:
    """Origin and direction through an image point."""
    origin = _add(
        _row(frame, 0, 0), _add(_scaled(_row(frame, 2, 0), u), _scaled(_row(frame, 4, 0), v))
    )
    direction = _add(
        _row(frame, 1, 0), _add(_scaled(_row(frame, 3, 0), u), _scaled(_row(frame, 5, 0), v))
    )
    return origin, direction


@njit(cache=True, nogil=True)
def _row(table: Array, row: int, column: int) -> Vec:
    return table[row, column], table[row, column + 1], table[row, column + 2]


@njit(cache=True, nogil=True)
def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def _add(a: Vec, b: Vec) -> Vec:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True, nogil=True)
def _sub(a: Vec, b: Vec) -> Vec:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, nogil=True)
def _scaled(a: Vec, by: float) -> Vec:
    return a[0] * by, a[1] * by, a[2] * by


@njit(cache=True, nogil=True)
def _sky(backdrop: Backdrop, direction: Vec) -> Vec:
    """Colour of the sky: from the horizon's to the zenith's, by the sine of the elevation."""
    horizon, zenith, _ = backdrop
    share = max(0.0, direction[1]) / np.sqrt(_dot(direction, direction))
    return (
        horizon[0] + share * (zenith[0] - horizon[0]),
        horizon[1] + share * (zenith[1] - horizon[1]),
        horizon[2] + share * (zenith[2] - horizon[2]),
    )


@njit(cache=True, nogil=True)
def _value(facets: Array, facet: int, number: int, hit: Vec) -> float:
    """u, v, red, green or blue (number 0 to 4) at a hit point relative to the facet's corner."""
    value: float = facets[facet, 6 + number] + _dot(_row(facets, facet, 11 + 3 * number), hit)
    return value


@njit(cache=True, nogil=True)
def _footprint(frame: Array, direction: Vec, depth: float, facets: Array, facet: int) -> float:
    """Area in uv of one pixel (ray differentials, Igehy 1999)."""
    normal = _row(facets, facet, 3)
    u, v = _row(facets, facet, 11), _row(facets, facet, 14)
    slope = _dot(normal, direction)
    across = _add(_row(frame, 2, 0), _scaled(_row(frame, 3, 0), depth))
    down = _add(_row(frame, 4, 0), _scaled(_row(frame, 5, 0), depth))
    across = _add(across, _scaled(direction, -_dot(normal, across) / slope))
    down = _add(down, _scaled(direction, -_dot(normal, down) / slope))
    area: float = abs(_dot(u, across) * _dot(v, down) - _dot(u, down) * _dot(v, across))
    return area


@njit(cache=True, nogil=True)
def _texel(u: float, v: float, area: float, texture: int, atlas: Atlas) -> Vec:
    """Trilinear colour; the level is the one whose texels have the footprint's area."""
    _, start, shape = atlas
    exact = 0.5 * np.log2(max(1e-30, area * shape[texture, 0, 0] * shape[texture, 0, 1]))
    exact = min(max(exact, 0.0), start.shape[1] - 1.0)
    level = int(exact)
    part = exact - level
    colour: Vec = _bilinear(u, v, texture, level, atlas)
    if part > 0.0:
        coarse = _bilinear(u, v, texture, level + 1, atlas)
        colour = _add(_scaled(colour, 1.0 - part), _scaled(coarse, part))
    return colour


@njit(cache=True, nogil=True)
def _bilinear(u: float, v: float, texture: int, level: int, atlas: Atlas) -> Vec:
    """Colour between the four nearest texels of one level; textures repeat."""
    texels, start, shape = atlas
    height, width = shape[texture, level, 0], shape[texture, level, 1]
    column = (u - np.floor(u)) * width - 0.5
    row = (v - np.floor(v)) * height - 0.5
    left, upper = int(np.floor(column)), int(np.floor(row))
    x, y = column - left, row - upper
    first = start[texture, level] + (upper % height) * width
    second = start[texture, level] + ((upper + 1) % height) * width
    left, right = left % width, (left + 1) % width
    above = _add(
        _scaled(_row(texels, first + left, 0), 1.0 - x), _scaled(_row(texels, first + right, 0), x)
    )
    below = _add(
        _scaled(_row(texels, second + left, 0), 1.0 - x),
        _scaled(_row(texels, second + right, 0), x),
    )
    colour: Vec = _add(_scaled(above, 1.0 - y), _scaled(below, y))
    return colour
