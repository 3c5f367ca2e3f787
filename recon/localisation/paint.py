"""Paint: the colours of solids, as a pixel shows them from nearby or from afar."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.localisation.drawing import Array, Indices, Solids, Views, place_on, shares

LEAST_COSINE = 0.2
"""Least cosine of the angle between a line of sight and a normal that makes a pixel show more."""


class Paint(NamedTuple):
    """Colours of texels, and of what is behind them."""

    grid: Indices
    """(S, L, 2) numbers of texels around and along each solid, at levels from fine to coarse."""
    first: Indices
    """(S, L) first texel of each level."""
    mean: NDArray[np.float32]
    """(K, 3) RGB."""
    sigma: NDArray[np.float32]
    """(K,) standard deviation of each channel; 0 for texels that may be just as seen."""
    backdrop: Array
    """(B, L, L, L) log density of the colours in each band of elevations."""
    behind: Array
    """(B, 3) mean colour of the backdrop in each band ..."""
    behind_sigma: Array
    """(B,) ... and the standard deviation of a channel."""


@njit(cache=True, nogil=True, inline="always")
def _level(
    solids: Solids,
    views: Views,
    s: int,
    paint: Paint,
    place: tuple[float, float, float],
    wide: float,
) -> int:
    """The level whose texels are about as large as what a pixel shows, `wide` if seen frontally."""
    levels = paint.grid.shape[1]
    if levels == 1:
        return 0
    x, y, t = place
    rise = 0.5 * solids.radius_sq[s, 1] + solids.radius_sq[s, 2] * t
    slant = math.sqrt(x * x + y * y + rise * rise)
    to = (views.eye[s, 0] - x, views.eye[s, 1] - y, views.eye[s, 2] - t)
    away = math.sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2])
    cosine = abs(x * to[0] + y * to[1] - rise * to[2]) / max(slant * away, 1e-9)
    area = wide * wide / max(cosine, LEAST_COSINE)
    length = solids.ends[s, 1] - solids.ends[s, 0]
    own = 2.0 * math.pi * slant * length / (paint.grid[s, 0, 0] * paint.grid[s, 0, 1])
    level = math.floor(0.5 * math.log2(area / max(own, 1e-12)))
    kept: int = min(max(level, 0), levels - 1)
    return kept


@njit(cache=True, nogil=True, inline="always")
def painted(
    solids: Solids,
    views: Views,
    s: int,
    paint: Paint,
    ray: tuple[float, float, float],
    depth: float,
    colour: Array,
) -> float:
    """Add the colour where a ray meets a solid; returns the standard deviation.

    It is that of the texels around, as large as the pixel, whose side is `ray[2]`.
    """
    place = place_on(solids, views, s, (ray[0], ray[1]), depth)
    level = _level(solids, views, s, paint, place, depth * ray[2])
    share = shares(solids, s, place)
    around, along = paint.grid[s, level, 0], paint.grid[s, level, 1]
    a, b = share[0] * around - 0.5, min(max(share[1] * along - 0.5, 0.0), along - 1.0)
    left, low = math.floor(a), min(int(b), max(along - 2, 0))
    a, b = a - left, b - low
    spread, start = 0.0, paint.first[s, level]
    for corner in range(4):
        aside, above = corner & 1, corner >> 1
        part = (a if aside else 1.0 - a) * (b if above else 1.0 - b)
        if part > 0.0:
            k = start + (left + aside) % around * along + low + above
            if paint.sigma[k] <= 0.0:
                return 0.0
            spread += part * paint.sigma[k]
            colour[0] += part * paint.mean[k, 0]
            colour[1] += part * paint.mean[k, 1]
            colour[2] += part * paint.mean[k, 2]
    return spread
