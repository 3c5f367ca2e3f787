"""Revolved: solids of revolution in the form in which they are drawn, and their texels."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from recon.geometry import Array
from recon.localisation.drawing import Solids
from recon.recognition.fitting.axes import across_axis
from recon.recognition.fitting.surface_points import outline
from recon.records import Cone, Cylinder, Ellipsoid, Solid, Sphere, TruncatedCone

Mask = NDArray[np.bool_]

SECTORS = 12
"""Texels around a solid are a multiple of these: a texture that goes around it two, three, four or
six times repeats after whole texels."""
ROUND = Sphere | Ellipsoid | Cylinder | Cone | TruncatedCone


def revolved(solids: Sequence[Solid], side: float) -> Solids:
    """Solids with texels of a side, world units."""
    found = [_revolved(solid) for solid in solids]
    origin, frame, radius_sq, ends = (np.array(values) for values in zip(*found, strict=True))
    widest = np.array([_radii(*one, 100)[1].max() for one in zip(radius_sq, ends, strict=True)])
    around = SECTORS * np.maximum(1.0, np.ceil(2.0 * np.pi * widest / side / SECTORS))
    along = 2.0 * np.maximum(1.0, np.ceil(np.ptp(ends, axis=1) / side / 2.0))
    shape = np.column_stack([around, along]).astype(np.int64)
    return Solids(
        origin=origin, frame=frame, radius_sq=radius_sq, ends=ends,
        reach=np.hypot(widest, np.abs(ends).max(axis=1)),
        shape=shape,
    )  # fmt: skip


def _revolved(solid: Solid) -> tuple[Array, Array, Array, Array]:
    """Origin, frame, squared radius and ends of a solid, as `Solids` has them."""
    origin, axis, profile = outline(solid)
    is_ball = isinstance(solid, Sphere | Ellipsoid)
    ends, radii = profile[[0, -1]].T
    if is_ball:
        radii = np.full(2, profile[:, 1].max())
    radius_sq = squared_radii(np.array([is_ball]), ends[None], radii[None])[0]
    return origin, np.vstack([across_axis(axis), axis]), radius_sq, ends


def squared_radii(is_ball: Mask, ends: Array, radii: Array) -> Array:
    """Coefficients (S, 3) of the squared radii along axes, as `Solids` has them.

    Parameters
    ----------
    is_ball : (S,) array of bool
        True for a sphere or an ellipsoid, whose middle is at 0.
    ends : (S, 2) array
        First and last place along the axis.
    radii : (S, 2) array
        At the ends; of a ball, its largest.
    """
    length = np.maximum(ends[:, 1] - ends[:, 0], 1e-9)
    slope = (radii[:, 1] - radii[:, 0]) / length
    base = radii[:, 0] - slope * ends[:, 0]
    straight = np.column_stack([base**2, 2.0 * base * slope, slope**2])
    bend = -((2.0 * radii[:, 0] / length) ** 2)
    ball = np.column_stack([radii[:, 0] ** 2, np.zeros(len(bend)), bend])
    return np.asarray(np.where(is_ball[:, None], ball, straight), np.float64)


def _radii(radius_sq: Array, ends: Array, number: int) -> tuple[Array, Array]:
    """Middles of so many bands along an axis, and the radii there."""
    share = (np.arange(number) + 0.5) / number
    t = ends[0] + share * (ends[1] - ends[0])
    return t, np.sqrt(np.maximum(radius_sq @ [np.ones(number), t, t**2], 1e-12))
