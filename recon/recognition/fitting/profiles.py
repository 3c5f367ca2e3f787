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
Profile = Pair
"""rho and y."""
Profiles = tuple[Array, Array]
"""The same of several points."""

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
    x, z, y = points[:, 0] - axis[0], points[:, 2] - axis[1], points[:, 1].copy()
    rho = np.maximum(np.sqrt(x * x + z * z), 1e-12)
    signed, nearest = _nearest((rho, y), heights, outlines, radii, counts)
    first = 2 + len(outlines)
    # Stored by columns, along which the normal equations add up.
    gradient = np.zeros((first + counts.sum(), len(points))).T
    columns, numbers = np.cumsum(counts) - counts, np.empty(7)
    for i in range(len(points)):
        part = nearest[i]
        own, count = columns[part], counts[part]
        ends = heights[part], heights[part + 1]
        if outlines[part] == ARC:
            _to_arc((rho[i], y[i]), ends, radii[own] if count else 0.0, count == 0, numbers)
        else:
            _to_segment((rho[i], y[i]), ends, (radii[own], radii[own + count - 1]), numbers)
        gradient[i, 0] = -numbers[0] * x[i] / rho[i]
        gradient[i, 1 + part], gradient[i, 2 + part] = numbers[2], numbers[3]
        if count == 1:
            gradient[i, first + own] = numbers[4] + numbers[5]
        elif count == 2:
            gradient[i, first + own], gradient[i, first + own + 1] = numbers[4], numbers[5]
        # The lowest end is the known ground.
        gradient[i, 1] = -numbers[0] * z[i] / rho[i]
    return signed, gradient, nearest


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
def _to_segment(profile: Profile, ends: Pair, rims: Pair, out: Array) -> None:
    """Write the derivatives of the distance by rho, y, both ends and both radii."""
    (rho, y), (low, high), (bottom, top) = profile, ends, rims
    run, rise = top - bottom, high - low
    share = ((rho - bottom) * run + (y - low) * rise) / max(run * run + rise * rise, 1e-12)
    share = min(max(share, 0.0), 1.0)
    across, up = rho - bottom - share * run, y - low - share * rise
    length = math.sqrt(across * across + up * up)
    side = -1.0 if across * rise - up * run < 0 else 1.0
    normal_rho, normal_y = side * across / max(length, 1e-12), side * up / max(length, 1e-12)
    # The derivative of a distance keeps the nearest point at its position on the segment.
    out[0], out[1] = normal_rho, normal_y
    out[2], out[3] = -(1.0 - share) * normal_y, -share * normal_y
    out[4], out[5] = -(1.0 - share) * normal_rho, -share * normal_rho


@njit(cache=True, error_model="numpy")
def _to_arc(profile: Profile, ends: Pair, radius: float, is_sphere: bool, out: Array) -> None:
    """Write the same for a sphere, or an ellipsoid of a radius."""
    (rho, y), (low, high) = profile, ends
    middle, half = (low + high) / 2.0, max((high - low) / 2.0, 1e-6)
    wide = half if is_sphere else max(radius, 1e-6)
    u, v = rho / wide, (y - middle) / half
    level = max(math.sqrt(u * u + v * v), 1e-9)
    slope_rho, slope_y = u / wide / level, v / half / level
    # Level over its slope; the slope is treated as constant in the derivative.
    scale = 1.0 / max(math.sqrt(slope_rho * slope_rho + slope_y * slope_y), 1e-9)
    by_half, by_radius = -v * v / level / half, -u * u / level / wide
    if is_sphere:
        by_half += by_radius
    out[0], out[1] = slope_rho * scale, slope_y * scale
    out[2], out[3] = (-slope_y - by_half) / 2.0 * scale, (-slope_y + by_half) / 2.0 * scale
    out[4], out[5] = by_radius * scale, 0.0
