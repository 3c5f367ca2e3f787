"""Distances of points to upright parts of revolution, compiled.

An upright part seen in the half plane (rho, y), rho = distance from the vertical axis, is a curve:
a straight line for a cylinder and a cone, an arc for a sphere and an ellipsoid.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Profile = tuple[float, float]
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
        profile = max(np.hypot(x, z), 1e-12), points[i, 1]
        column = first
        for part in range(num_parts):
            own = radii[column - first : column - first + counts[part]]
            _to_part(profile, heights[part : part + 2], outlines[part], own, numbers)
            if abs(numbers[0]) < abs(signed[i]):
                signed[i], nearest[i] = numbers[0], part
                gradient[i] = 0.0
                gradient[i, 0] = -numbers[1] * x / profile[0]
                gradient[i, 1 + part : 3 + part] = numbers[3:5]
                gradient[i, column : column + len(own)] = numbers[5 : 5 + len(own)]
                # The lowest end is the known ground.
                gradient[i, 1] = -numbers[1] * z / profile[0]
            column += len(own)
    return signed, gradient, nearest


@njit(cache=True)
def _to_part(profile: Profile, ends: Array, outline: int, radii: Array, out: Array) -> None:
    """Write the signed distance and its derivatives by rho, y, both ends and the radii."""
    if outline == ARC:
        _to_arc(profile, ends, radii, out)
    else:
        _to_segment(profile, ends, radii, out)


@njit(cache=True)
def _to_segment(profile: Profile, ends: Array, radii: Array, out: Array) -> None:
    (rho, y), low, high = profile, ends[0], ends[1]
    bottom, top = radii[0], radii[-1]
    run, rise = top - bottom, high - low
    share = ((rho - bottom) * run + (y - low) * rise) / max(run * run + rise * rise, 1e-12)
    share = min(max(share, 0.0), 1.0)
    across, up = rho - bottom - share * run, y - low - share * rise
    length = np.hypot(across, up)
    side = -1.0 if across * rise - up * run < 0 else 1.0
    normal_rho, normal_y = side * across / max(length, 1e-12), side * up / max(length, 1e-12)
    # The derivative of a distance keeps the nearest point at its position on the segment.
    out[0], out[1], out[2] = side * length, normal_rho, normal_y
    out[3], out[4] = -(1.0 - share) * normal_y, -share * normal_y
    out[5], out[6] = -(1.0 - share) * normal_rho, -share * normal_rho
    if len(radii) == 1:
        out[5] += out[6]


@njit(cache=True)
def _to_arc(profile: Profile, ends: Array, radii: Array, out: Array) -> None:
    (rho, y), low, high = profile, ends[0], ends[1]
    middle, half = (low + high) / 2.0, max((high - low) / 2.0, 1e-6)
    wide = max(radii[0], 1e-6) if len(radii) else half
    u, v = rho / wide, (y - middle) / half
    level = max(np.hypot(u, v), 1e-9)
    slope_rho, slope_y = u / wide / level, v / half / level
    # Level over its slope; the slope is treated as constant in the derivative.
    scale = 1.0 / max(np.hypot(slope_rho, slope_y), 1e-9)
    by_half, by_radius = -v * v / level / half, -u * u / level / wide
    if len(radii) == 0:
        by_half += by_radius
    out[0], out[1], out[2] = (level - 1.0) * scale, slope_rho * scale, slope_y * scale
    out[3], out[4] = (-slope_y - by_half) / 2.0 * scale, (-slope_y + by_half) / 2.0 * scale
    out[5] = by_radius * scale
