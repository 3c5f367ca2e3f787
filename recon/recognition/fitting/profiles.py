"""Distances of profile points (rho, y) to the outline of upright parts of revolution.

An upright part seen in the half plane (rho, y), rho = distance from the vertical axis, is a curve:
a straight line for a cylinder and a cone, an arc for a sphere and an ellipsoid.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NUM_RADII = {"cylinder": 1, "sphere": 0, "ellipsoid": 1, "truncated cone": 2}
"""Numbers of a part beside its lower and upper end."""


def distance(shape: str, profile: Array, ends: Array, radii: Array) -> tuple[Array, Array, Array]:
    """Signed distance of profile points to a part.

    Parameters
    ----------
    shape : str
        A key of `NUM_RADII`.
    profile : (N, 2) float64
        rho and y.
    ends : (2,) float64
        Lower and upper end.
    radii : (NUM_RADII[shape],) float64
        Cylinder: its radius; truncated cone: bottom and top; ellipsoid: horizontal.

    Returns
    -------
    distance : (N,)
    normal : (N, 2)
        Derivative by the point.
    gradient : (N, 2 + len(radii))
        Derivative by the ends and the radii.
    """
    if shape in ("sphere", "ellipsoid"):
        return _arc(profile, ends, radii)
    signed, normal, by_corner = _segment(profile, ends, radii[0], radii[-1])
    if shape == "cylinder":
        by_corner = np.column_stack([by_corner[:, :2], by_corner[:, 2] + by_corner[:, 3]])
    return signed, normal, by_corner


def _segment(profile: Array, ends: Array, bottom: float, top: float) -> tuple[Array, Array, Array]:
    start = np.array([bottom, ends[0]])
    along = np.array([top, ends[1]]) - start
    share = np.clip((profile - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
    offset = profile - start - share[:, None] * along
    length = np.hypot(offset[:, 0], offset[:, 1])
    side = np.where(offset @ np.array([along[1], -along[0]]) < 0, -1.0, 1.0)
    normal = side[:, None] * offset / np.maximum(length, 1e-12)[:, None]
    # The nearest point stays at its share of the segment: the derivative of a distance.
    by_y, by_rho = -normal[:, 1], -normal[:, 0]
    stay, go = 1.0 - share, share
    return (
        side * length,
        normal,
        np.column_stack([stay * by_y, go * by_y, stay * by_rho, go * by_rho]),
    )


def _arc(profile: Array, ends: Array, radii: Array) -> tuple[Array, Array, Array]:
    middle, half = ends.mean(), max(float(ends[1] - ends[0]) / 2.0, 1e-6)
    radius = max(float(radii[0]), 1e-6) if len(radii) else half
    u, v = profile[:, 0] / radius, (profile[:, 1] - middle) / half
    level = np.maximum(np.hypot(u, v), 1e-9)
    slope = np.column_stack([u / radius, v / half]) / level[:, None]
    # The first-order distance: level over its slope, which is held while it is differentiated.
    scale = 1.0 / np.maximum(np.hypot(slope[:, 0], slope[:, 1]), 1e-9)
    by_middle = -slope[:, 1]
    by_half = -v * v / level / half
    by_radius = -u * u / level / radius
    if not len(radii):
        by_half = by_half + by_radius
    columns = [by_middle / 2 - by_half / 2, by_middle / 2 + by_half / 2]
    gradient = np.column_stack(columns + ([by_radius] if len(radii) else []))
    return (level - 1.0) * scale, slope * scale[:, None], gradient * scale[:, None]
