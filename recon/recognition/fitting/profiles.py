"""Distances of points to upright parts of revolution, compiled.

An upright part seen in the half plane (rho, y), rho = distance from the vertical axis, is a curve:
a straight line for a cylinder and a cone, an arc for a sphere and an ellipsoid.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Pair = tuple[float, float]
Profiles = tuple[Array, Array]
"""rho and y of points."""

NUM_RADII = {"cylinder": 1, "sphere": 0, "ellipsoid": 1, "truncated cone": 2}
"""Number of radii of a part, besides its lower and upper end."""
SEGMENT, ARC = 0, 1
"""Outline types of a part."""
OUTLINES = {"cylinder": SEGMENT, "sphere": ARC, "ellipsoid": ARC, "truncated cone": SEGMENT}


@njit(cache=True)
def to_parts(
    points: Array, axis: Array, heights: Array, outlines: Numbers, radii: Array, counts: Numbers
) -> tuple[Array, Array, Numbers]:
    """Distances of points to the nearest of the upright parts on one axis.

    Parameters
    ----------
    points : (N, 3)
    axis : (2,) x and z
    heights : (parts + 1,) of the ends
    outlines : (parts,) `SEGMENT` or `ARC`
    radii : (sum(counts),) those of each part, one part after the other
    counts : (parts,) number of radii of each part

    Returns
    -------
    signed : (N,)
    gradient : (N, 2 + parts + sum(counts))
        With respect to the axis, the heights above the ground, and the radii.
    nearest : (N,) number of the part
    """
    # Four arrays, not one: the compiler must see that they do not overlap.
    size = len(points)
    x, z, rho, y = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    for i in range(len(points)):
        x[i], z[i], y[i] = points[i, 0] - axis[0], points[i, 2] - axis[1], points[i, 1]
        rho[i] = max(math.sqrt(x[i] * x[i] + z[i] * z[i]), 1e-12)
    signed, nearest = _nearest((rho, y), heights, outlines, radii, counts)
    first, own = 2 + len(outlines), 2 + len(outlines)
    # A row for each step, along which the normal equations add up.
    gradient, slopes = np.zeros((first + counts.sum(), len(points))), np.empty((5, len(points)))
    for part in range(len(outlines)):
        ends, count, rims = (heights[part], heights[part + 1]), counts[part], radii[own - first :]
        if outlines[part] == ARC:
            _to_arc((rho, y), ends, rims[0] if count else 0.0, count == 0, slopes)
        else:
            _to_segment((rho, y), ends, (rims[0], rims[count - 1]), slopes)
        if count == 1:
            slopes[3] += slopes[4]
        _add_own(slopes[0], nearest, part, gradient[0])
        # The lowest end is the known ground.
        if part > 0:
            _add_own(slopes[1], nearest, part, gradient[1 + part])
        _add_own(slopes[2], nearest, part, gradient[2 + part])
        for k in range(count):
            _add_own(slopes[3 + k], nearest, part, gradient[own + k])
        own += count
    for i in range(len(points)):
        outwards = gradient[0, i]
        gradient[0, i], gradient[1, i] = -outwards * x[i] / rho[i], -outwards * z[i] / rho[i]
    return signed, gradient.T, nearest


@njit(cache=True)
def _add_own(slopes: Array, nearest: Numbers, part: int, total: Array) -> None:
    """Add the slopes (N,) of the points that are nearest to one part."""
    for i in range(len(total)):
        total[i] += slopes[i] if nearest[i] == part else 0.0


@njit(cache=True)
def _nearest(
    profiles: Profiles, heights: Array, outlines: Numbers, radii: Array, counts: Numbers
) -> tuple[Array, Numbers]:
    """Signed distances (N,) to the nearest of the parts, and its number (N,)."""
    signed = np.full(len(profiles[0]), np.inf)
    nearest, own = np.zeros(len(signed), dtype=np.int64), 0
    for part in range(len(outlines)):
        ends, count = (heights[part], heights[part + 1]), counts[part]
        if outlines[part] == ARC:
            away = _from_arc(profiles, ends, radii[own] if count else 0.0, count == 0)
        else:
            away = _from_segment(profiles, ends, (radii[own], radii[own + count - 1]))
        for i in range(len(signed)):
            if abs(away[i]) < abs(signed[i]):
                signed[i], nearest[i] = away[i], part
        own += count
    return signed, nearest


@njit(cache=True, error_model="numpy")
def _from_segment(profiles: Profiles, ends: Pair, rims: Pair) -> Array:
    """Signed distances (N,) to a segment."""
    (rho, y), (low, high), (bottom, top) = profiles, ends, rims
    run, rise, signed = top - bottom, high - low, np.empty(len(rho))
    square = max(run * run + rise * rise, 1e-12)
    for i in range(len(rho)):
        share = ((rho[i] - bottom) * run + (y[i] - low) * rise) / square
        share = min(max(share, 0.0), 1.0)
        across, up = rho[i] - bottom - share * run, y[i] - low - share * rise
        length = math.sqrt(across * across + up * up)
        signed[i] = -length if across * rise - up * run < 0 else length
    return signed


@njit(cache=True, error_model="numpy")
def _from_arc(profiles: Profiles, ends: Pair, radius: float, is_sphere: bool) -> Array:
    """The same to a sphere, or an ellipsoid of a radius."""
    (rho, y), (low, high) = profiles, ends
    middle, half, signed = (low + high) / 2.0, max((high - low) / 2.0, 1e-6), np.empty(len(rho))
    wide = half if is_sphere else max(radius, 1e-6)
    for i in range(len(rho)):
        u, v = rho[i] / wide, (y[i] - middle) / half
        level = max(math.sqrt(u * u + v * v), 1e-9)
        slope_rho, slope_y = u / wide / level, v / half / level
        slope = math.sqrt(slope_rho * slope_rho + slope_y * slope_y)
        signed[i] = (level - 1.0) / max(slope, 1e-9)
    return signed


@njit(cache=True, error_model="numpy")
def _to_segment(profiles: Profiles, ends: Pair, rims: Pair, out: Array) -> None:
    """Write the derivatives (5, N) of distances by rho, both ends and both radii."""
    (rhos, ys), (low, high), (bottom, top) = profiles, ends, rims
    run, rise = top - bottom, high - low
    square = max(run * run + rise * rise, 1e-12)
    for i in range(len(rhos)):
        share = ((rhos[i] - bottom) * run + (ys[i] - low) * rise) / square
        share = min(max(share, 0.0), 1.0)
        across, up = rhos[i] - bottom - share * run, ys[i] - low - share * rise
        length = math.sqrt(across * across + up * up)
        side = -1.0 if across * rise - up * run < 0 else 1.0
        normal_rho, normal_y = side * across / max(length, 1e-12), side * up / max(length, 1e-12)
        # The derivative of a distance keeps the nearest point at its position on the segment.
        out[0, i] = normal_rho
        out[1, i], out[2, i] = -(1.0 - share) * normal_y, -share * normal_y
        out[3, i], out[4, i] = -(1.0 - share) * normal_rho, -share * normal_rho


@njit(cache=True, error_model="numpy")
def _to_arc(profiles: Profiles, ends: Pair, radius: float, is_sphere: bool, out: Array) -> None:
    """Write the same for a sphere, or an ellipsoid of a radius."""
    (rhos, ys), (low, high) = profiles, ends
    middle, half = (low + high) / 2.0, max((high - low) / 2.0, 1e-6)
    wide = half if is_sphere else max(radius, 1e-6)
    for i in range(len(rhos)):
        u, v = rhos[i] / wide, (ys[i] - middle) / half
        level = max(math.sqrt(u * u + v * v), 1e-9)
        slope_rho, slope_y = u / wide / level, v / half / level
        # Level over its slope; the slope is treated as constant in the derivative.
        scale = 1.0 / max(math.sqrt(slope_rho * slope_rho + slope_y * slope_y), 1e-9)
        by_half, by_radius = -v * v / level / half, -u * u / level / wide
        by_half += by_radius if is_sphere else 0.0
        out[0, i] = slope_rho * scale
        out[1, i] = (-slope_y - by_half) / 2.0 * scale
        out[2, i] = (-slope_y + by_half) / 2.0 * scale
        out[3, i], out[4, i] = by_radius * scale, 0.0
