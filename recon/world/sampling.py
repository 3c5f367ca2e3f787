"""The one compiled loop: from what a ray hits to its colour."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.geometry import Array


@njit(cache=True, nogil=True)
def shade(
    rays: tuple[Array, Array, Array],
    triangle: NDArray[np.int32],
    surface: tuple[Array, NDArray[np.int32]],
    atlas: tuple[NDArray[np.uint8], NDArray[np.int64], NDArray[np.int64]],
    backdrop: tuple[Array, float],
    depth: Array,
    colour: Array,
) -> None:
    """Colours and depths of rays, from the triangles they hit.

    Parameters
    ----------
    rays : origins (N, 3), directions (N, 3), and steps (4, 3)
        The steps are the change of origin and direction from one sample to the next along u and
        along v: origin u, direction u, origin v, direction v.
    triangle : (N,) what each ray hits, -1 = nothing
    surface : see `Surface`: facets (T, 22), texture (T,) of each, -1 = none
    atlas : texels, start, shape of a `TextureAtlas`
    backdrop : red, green, blue of what is not there, and the density of the fog before it
    depth : (N,) out, along a direction's own length, NaN = nothing
    colour : (N, 3) out, 0 to 255
    """
    origins, directions, steps = rays
    facets, texture = surface
    sky, fog = backdrop
    value = np.empty(5)
    texel = np.empty(3)
    for n in range(len(triangle)):
        facet = triangle[n]
        if facet < 0:
            depth[n] = np.nan
            colour[n] = sky
            continue
        area, depth[n] = _surface_values(origins[n], directions[n], steps, facets[facet], value)
        _texture_colour(value, area, texture[facet], atlas, texel)
        clear = np.exp(-fog * depth[n]) if fog > 0 else 1.0
        for c in range(3):
            lit = min(255.0, texel[c] * value[2 + c])
            colour[n, c] = clear * lit + (1.0 - clear) * sky[c]


@njit(cache=True, nogil=True)
def _surface_values(
    origin: Array, direction: Array, steps: Array, facet: Array, value: Array
) -> tuple[float, float]:
    """Fill in u, v, red, green, blue at the hit; return the footprint's area in uv, and depth."""
    normal = facet[3:6]
    slope = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2]
    depth = 0.0
    for k in range(3):
        depth += normal[k] * (facet[k] - origin[k]) / slope
    for i in range(5):
        value[i] = facet[6 + i]
        for k in range(3):
            at = origin[k] + depth * direction[k] - facet[k]
            value[i] += facet[11 + 3 * i + k] * at
    u_u, v_u = _uv_step(steps[0], steps[1], direction, depth, slope, facet)
    u_v, v_v = _uv_step(steps[2], steps[3], direction, depth, slope, facet)
    return abs(u_u * v_v - u_v * v_u), depth


@njit(cache=True, nogil=True)
def _uv_step(
    origin_step: Array,
    direction_step: Array,
    direction: Array,
    depth: float,
    slope: float,
    facet: Array,
) -> tuple[float, float]:
    """Change of u and v at the hit from one sample to the next (Igehy 1999, ray differentials)."""
    along = 0.0
    for k in range(3):
        along -= facet[3 + k] * (origin_step[k] + depth * direction_step[k]) / slope
    u, v = 0.0, 0.0
    for k in range(3):
        move = origin_step[k] + depth * direction_step[k] + along * direction[k]
        u += facet[11 + k] * move
        v += facet[14 + k] * move
    return u, v


@njit(cache=True, nogil=True)
def _texture_colour(
    value: Array,
    area: float,
    texture: int,
    atlas: tuple[NDArray[np.uint8], NDArray[np.int64], NDArray[np.int64]],
    texel: Array,
) -> None:
    """Trilinear colour; the level is the one whose texels have the footprint's area."""
    texels, start, shape = atlas
    texel[:] = 0.0
    if texture < 0:
        texel[:] = 255.0
        return
    height, width = shape[texture, 0]
    num_levels = start.shape[1]
    exact = 0.5 * np.log2(max(1e-30, area * height * width))
    exact = min(max(exact, 0.0), num_levels - 1.0)
    level = int(exact)
    part = exact - level
    _add_bilinear(value, 1.0 - part, texels, start[texture, level], shape[texture, level], texel)
    if part > 0.0:
        level += 1
        _add_bilinear(value, part, texels, start[texture, level], shape[texture, level], texel)


@njit(cache=True, nogil=True)
def _add_bilinear(
    value: Array,
    weight: float,
    texels: NDArray[np.uint8],
    start: int,
    shape: NDArray[np.int64],
    texel: Array,
) -> None:
    """Add `weight` times the colour between the four nearest texels of one level."""
    height, width = shape
    column = (value[0] - np.floor(value[0])) * width - 0.5
    row = (value[1] - np.floor(value[1])) * height - 0.5
    left, upper = int(np.floor(column)), int(np.floor(row))
    x, y = column - left, row - upper
    right, lower = (left + 1) % width, (upper + 1) % height
    left, upper = left % width, upper % height
    first, second = start + upper * width, start + lower * width
    for c in range(3):
        above = (1.0 - x) * texels[first + left, c] + x * texels[first + right, c]
        below = (1.0 - x) * texels[second + left, c] + x * texels[second + right, c]
        texel[c] += weight * ((1.0 - y) * above + y * below)
