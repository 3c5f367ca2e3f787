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
    num_parts, first = len(outlines), 2 + len(outlines)
    signed = np.full(len(points), np.inf)
    nearest = np.zeros(len(points), dtype=np.int64)
    gradient = np.zeros((len(points), first + counts.sum()))
    numbers = np.empty(7)
    for i in range(len(points)):
        x, z = points[i, 0] - axis[0], points[i, 2] - axis[1]
        profile = max(math.sqrt(x * x + z * z), 1e-12), points[i, 1]
        column = first
        for part in range(num_parts):
            ends, own = (heights[part], heights[part + 1]), column - first
            rims = (radii[own], radii[own + counts[part] - 1]) if counts[part] else (0.0, 0.0)
            if outlines[part] == ARC:
                _to_arc(profile, ends, rims[0], counts[part] == 0, numbers)
            else:
                _to_segment(profile, ends, rims, counts[part] == 1, numbers)
            if abs(numbers[0]) < abs(signed[i]):
                signed[i], nearest[i] = numbers[0], part
                gradient[i] = 0.0
                gradient[i, 0] = -numbers[1] * x / profile[0]
                gradient[i, 1 + part], gradient[i, 2 + part] = numbers[3], numbers[4]
                gradient[i, column : column + counts[part]] = numbers[5 : 5 + counts[part]]
                # The lowest end is the known ground.
                gradient[i, 1] = -numbers[1] * z / profile[0]
            column += counts[part]
    return signed, gradient, nearest


@njit(cache=True)
def _to_segment(profile: Profile, ends: Pair, rims: Pair, is_straight: bool, out: Array) -> None:
    """Write the signed distance and its derivatives by rho, y, both ends and the radii."""
    (rho, y), (low, high), (bottom, top) = profile, ends, rims
    run, rise = top - bottom, high - low
    share = ((rho - bottom) * run + (y - low) * rise) / max(run * run + rise * rise, 1e-12)
    share = min(max(share, 0.0), 1.0)
    across, up = rho - bottom - share * run, y - low - share * rise
    length = math.sqrt(across * across + up * up)
    side = -1.0 if across * rise - up * run < 0 else 1.0
    normal_rho, normal_y = side * across / max(length, 1e-12), side * up / max(length, 1e-12)
    # The derivative of a distance keeps the nearest point at its position on the segment.
    out[0], out[1], out[2] = side * length, normal_rho, normal_y
    out[3], out[4] = -(1.0 - share) * normal_y, -share * normal_y
    out[5], out[6] = -(1.0 - share) * normal_rho, -share * normal_rho
    if is_straight:
        out[5] += out[6]


@njit(cache=True)
def _to_arc(profile: Profile, ends: Pair, radius: float, is_sphere: bool, out: Array) -> None:
    """Write the same for a sphere, or an ellipsoid of a radius."""
    (rho, y), (low, high) = profile, ends
    middle, half = (low + high) / 2.0, max((high - low) / 2.0, 1e-6)
    wide = half if is_sphere else max(radius, 1e-6)
    u, v = rho / wide, (y - middle) / half
    level = max(math.sqrt(u * u + v * v), 1e-9)
    slope_rho, slope_y = u / wide / level, v / half / level
    # Level over its slope; the slope is treated as constant in the derivative.
    scale = 1.0 / max(math.sqrt(slope_rho**2 + slope_y**2), 1e-9)
    by_half, by_radius = -v * v / level / half, -u * u / level / wide
    if is_sphere:
        by_half += by_radius
    out[0], out[1], out[2] = (level - 1.0) * scale, slope_rho * scale, slope_y * scale
    out[3], out[4] = (-slope_y - by_half) / 2.0 * scale, (-slope_y + by_half) / 2.0 * scale
    out[5] = by_radius * scale
